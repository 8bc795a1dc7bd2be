"""Options of the bridge."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from hil.net.endpoint import BadAddress, check_joined, listen_address

USUAL_PORT = 7447
"""Port of zenoh's routers."""
ENDPOINTS_SCHEMA = WithJsonSchema(
    {
        "anyOf": [
            {"type": "array", "items": {"type": "string"}},
            {"type": "string"},
            {"type": "integer"},
        ]
    }
)


def endpoints(given: Any) -> Any:
    """Complete the addresses of ``listen``: one alone is a list of one, and one without a transport is by
    TCP. What is no address is left as it is, for zenoh to read or the model to refuse."""
    several = given if isinstance(given, list) else [given]
    if any(isinstance(each, bool) or not isinstance(each, str | int) for each in several):
        return given
    completed = []
    for at, each in enumerate(several):
        try:
            completed.append(with_transport(each))
        except BadAddress as error:
            problem = {"why": str(error), "remedy": error.remedy, "at": (at,) if several is given else ()}
            raise PydanticCustomError("listen", "{why}", problem) from None
    return completed


def joined(given: list[str]) -> list[str]:
    """Check the addresses of ``connect``."""
    for at, each in enumerate(given):
        try:
            check_joined(each)
        except BadAddress as error:
            problem = {"why": str(error), "remedy": error.remedy, "at": (at,)}
            raise PydanticCustomError("listen", "{why}", problem) from None
    return given


def with_transport(given: str | int) -> str:
    """Complete an address of zenoh: without a transport it is by TCP.

    Raises:
        BadAddress: it is none.
    """
    is_whole = isinstance(given, str) and "/" in given
    return str(given) if is_whole else f"tcp/{listen_address(given, USUAL_PORT)}"


class TlsOptions(BaseModel):
    """Certificates of a site; `hil zenoh keys` makes them."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    ca: Path = Field(description="The authority that all certificates are from.")
    certificate: Path = Field(description="This daemon's.")
    key: Path = Field(description="Its private key.")


class Options(BaseModel):
    """Options under ``bridges.zenoh``."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    listen: Annotated[list[str], BeforeValidator(endpoints), ENDPOINTS_SCHEMA] = Field(
        default=[f"tcp/127.0.0.1:{USUAL_PORT}"],
        description=(
            "Where others connect: an address and port, as in `127.0.0.1:7447`, which is by TCP, or one"
            " with its transport, as zenoh writes it: `tls/0.0.0.0:7447`; or a list of them. Beyond this"
            " computer it needs `site` or `users`, or `insecure: true`."
        ),
    )
    connect: Annotated[list[str], AfterValidator(joined)] = Field(
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
