"""Options of the metrics bridge."""

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from hil.net.endpoint import endpoint, is_loopback
from hil.net.listen_option import ADDRESS_SCHEMA, usual_at

USUAL_PORT = 9464
"""Port of OpenTelemetry's exporter for Prometheus."""


class Options(BaseModel):
    """Options under ``bridges.metrics``."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    listen: Annotated[str, usual_at(USUAL_PORT), ADDRESS_SCHEMA] = Field(
        default=f"127.0.0.1:{USUAL_PORT}",
        description=(
            'Address and port to listen at, as in `127.0.0.1:9464` or `"[::1]:9464"`; a port alone is of this'
            " computer, and port 0 any free one. Beyond this computer it needs `insecure: true`."
        ),
    )
    insecure: bool = Field(
        default=False, description="Let other computers read the metrics; log and status say so again."
    )

    @model_validator(mode="after")
    def _is_meant(self) -> Self:
        if not self.insecure and not is_loopback(endpoint(self.listen)[0]):
            raise PydanticCustomError(
                "reached",
                "{listen} is reached from other computers, and metrics have no users",
                {
                    "listen": self.listen,
                    "at": ("listen",),
                    "remedy": "listen on 127.0.0.1 and let a proxy ask who it is, or write `insecure: true`",
                },
            )
        return self
