"""Model of a segment's Modbus nodes in a configuration."""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field

from hil.config.explain import StrictModel

MODBUS = "modbus"
"""Key of the nodes of a segment, and name of a node behind its axis's."""
_Unit = Annotated[int, Field(ge=1, le=247)]


class ModbusConfig(StrictModel):
    """Modbus nodes of a segment: interface cards of axes."""

    units: Mapping[str, _Unit] = Field(
        min_length=1,
        description="Numbers of the nodes by axis, as in `{m1: 1, arm.elbow: 3}`. A node is a station of its"
        " own beside the board's UARTs, `m1.modbus`, with the registers of that axis; an axis has one.",
    )
    duplicate_units: bool = Field(
        default=False,
        description="Allow several nodes with one number, as new devices have: they answer at the same time,"
        " and their answers collide.",
    )
    word_order: Literal["high_first", "low_first"] = Field(
        default="high_first", description="Order of the registers of a value that takes several."
    )
    response_ms: float = Field(
        default=1.0,
        ge=0,
        le=60_000,
        description="Time from the end of a request, 3.5 characters behind its last one, to the start of the"
        " answer, in ms.",
    )
