"""Models of parts of a device in a configuration: its axes, their time-outs of set-points, its flash."""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from hil.config.explain import StrictModel, suggestion
from hil.config.port_model import usable_path
from hil.config.shaft_load import LoadConfig

BUILT_IN_TABLES = ("stored", "identity", "empty")
_TABLE_FILE_PATTERN = "[./]"


def _table(value: str) -> str:
    if value in BUILT_IN_TABLES:
        return value
    if "/" not in value and "." not in value:
        raise PydanticCustomError(
            "table",
            "there is no such table",
            {"remedy": suggestion(value, BUILT_IN_TABLES) + "; a file is written with its folder, as in ./x"},
        )
    usable: str = usable_path(value)
    return usable


_Table = Annotated[
    str,
    AfterValidator(_table),
    WithJsonSchema(
        {"anyOf": [{"enum": list(BUILT_IN_TABLES)}, {"type": "string", "pattern": _TABLE_FILE_PATTERN}]}
    ),
]


FieldStarts = Annotated[
    Mapping[str, float],
    Field(
        description="First values of the board's own fields that differ from the profile's, as in"
        " `{temperature_degC: 85}`."
    ),
]
"""Key of a device: values by the names of fields."""


class FlashConfig(StrictModel):
    """Content of the board's flash when the bench starts for the first time."""

    table: _Table = Field(
        default="stored",
        description="The encoder's look-up table: `stored` is what the last calibration left in the state"
        " directory; `identity` is that of a perfect encoder, angle = count * 360 / 16384; `empty` is a"
        " board that was never calibrated, all zeros; else the path of a file.",
    )
    address: int = Field(
        default=0xB900,
        ge=0,
        le=0x2FF00,
        multiple_of=256,
        description="Where the look-up table is in the board's flash, as the calibration prints it. It"
        " depends on how the firmware was linked.",
    )


Register = Annotated[int, Field(ge=0, le=0x7FFF)]
"""Contents of an encoder's register."""


class SetpointsConfig(StrictModel):
    """Time-out of set-points in a stream: what the axis does when the stream stops."""

    timeout_ms: float = Field(
        gt=0,
        le=3_600_000,
        description="Time without a set-point after which the axis stops, in ms, exact in simulated time.",
    )
    policy: Literal["hold", "decelerate", "torque_off"] = Field(
        default="decelerate",
        description="How it stops: `hold` at once where it is, `decelerate` with a ramp, `torque_off` without"
        " current (a SAC holds instead).",
    )
    acceleration_rpm_per_s: float = Field(
        default=600.0,
        ge=0.01,
        le=1e6,
        description="Acceleration of the ramp of `decelerate`; a SAC takes its session's deceleration.",
    )


class AxisConfig(StrictModel):
    """An axis of a board with several: keys that differ from the profile's."""

    plant: Literal["simple", "full"] | None = Field(
        default=None, description="The model of its motor and load; null: the device's."
    )
    motor: str | None = Field(default=None, description="Its motor, as the device's `motor`.")
    load: LoadConfig | None = Field(default=None, description="What its shaft turns, as the device's `load`.")
    axis: Mapping[str, float] = Field(
        default={}, description="Its parameters that differ from the profile's."
    )
    registers: Mapping[str, Register] = Field(
        default={}, description="Registers of its encoder at power-up that differ from the profile's."
    )
