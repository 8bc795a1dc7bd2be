"""Options of the metrics bridge."""

from typing import Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from hil.net.endpoint import endpoint, is_loopback


class Options(BaseModel):
    """Options under ``bridges.metrics``."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    listen: str = Field(
        default="127.0.0.1:9464",
        description=(
            "Address and port, as in `[::1]:9464`; port 0 takes a free one. Beyond this computer it needs"
            " `insecure: true`."
        ),
    )
    insecure: bool = Field(
        default=False, description="Let other computers read the metrics; log and status say so again."
    )

    @field_validator("listen")
    @classmethod
    def _has_the_form(cls, listen: str) -> str:
        try:
            endpoint(listen)
        except ValueError as error:
            raise PydanticCustomError(
                "listen",
                "{why}",
                {"why": str(error), "remedy": "write an address and a port, as in 127.0.0.1:9464"},
            ) from None
        return listen

    @model_validator(mode="after")
    def _is_meant(self) -> Self:
        if not self.insecure and not is_loopback(endpoint(self.listen)[0]):
            raise PydanticCustomError(
                "reached",
                "listen: {listen} is reached from other computers, and metrics have no users",
                {
                    "listen": self.listen,
                    "remedy": "listen on 127.0.0.1 and let a proxy ask who it is, or write `insecure: true`",
                },
            )
        return self
