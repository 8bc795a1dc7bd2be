"""Model of the magnet that an encoder reads. The descriptions are the reference's text."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Field, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from hil.config.explain import StrictModel


class MagnetConfig(StrictModel):
    """Magnet on a shaft, in front of an encoder."""

    of: str = Field(description="The shaft: a device with a motor, or one of its axes, as in `arm.ellbow`.")
    zero_deg: float = Field(
        default=0.0,
        ge=-1e6,
        le=1e6,
        description="Angle of the shaft at which the encoder reads 0, in deg. The shaft begins at `start_deg`"
        " of its axis; `hil zero` moves no magnet.",
    )
    reversed: bool = Field(
        default=False,
        description="Whether the encoder sees the shaft from behind: it counts down as the angle grows.",
    )


class _OrName:
    """Mark of a magnet whose shaft alone is given."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"type": "string"}, handler(schema)]}


def _from_name(value: Any) -> Any:
    return {"of": value} if isinstance(value, str) else value


MagnetKey = Annotated[MagnetConfig, BeforeValidator(_from_name), _OrName()]
"""Key of a magnet: a mapping, or the name of its shaft."""
