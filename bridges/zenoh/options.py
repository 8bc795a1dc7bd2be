"""Options of the bridge."""

from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field


class TlsOptions(BaseModel):
    """Certificates of a site; `hil zenoh keys` makes them."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    ca: Path = Field(description="The authority that all certificates are from.")
    certificate: Path = Field(description="This daemon's.")
    key: Path = Field(description="Its private key.")


class Options(BaseModel):
    """Options under ``bridges.zenoh``."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    listen: list[str] = Field(
        default=["tcp/127.0.0.1:7447"],
        description=(
            "Where others connect, as zenoh writes it. Beyond this computer it needs `users` or `tls`, or"
            " `insecure: true`."
        ),
    )
    connect: list[str] = Field(
        default=[],
        description="Routers to connect to, as in `tls/10.0.0.1:7447`; with `listen: []` only these.",
    )
    state_hz: float = Field(
        default=10.0,
        ge=0.1,
        le=1000,
        description="Samples of `state` (JSON) of each axis, in simulated time.",
    )
    packed_hz: float = Field(
        default=100.0, ge=0.1, le=1000, description="The same of `state/packed`, in the binary layout."
    )
    users: Path | None = Field(
        default=None,
        description="File of users with their roles and passwords; without it everybody may do everything.",
    )
    site: Path | None = Field(
        default=None,
        description=(
            "Folder of this bench that `hil zenoh site` makes: its certificate and the site's list of users."
            " Without `listen` and `connect` the bench joins the site's router."
        ),
    )
    tls: TlsOptions | None = Field(
        default=None, description="Certificates, both ways; needs `users` for roles."
    )
    insecure: bool = Field(
        default=False, description="Listen beyond this computer without users; log and status say so again."
    )
