"""Models of an axis in a configuration: its own keys, and its time-out of set-points."""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field

from hil.config.explain import StrictModel
from hil.config.shaft_load import LoadConfig

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
    load: LoadConfig | None = Field(default=None, description="What its shaft turns, as the device's `load`.")
    axis: Mapping[str, float] = Field(
        default={}, description="Its parameters that differ from the profile's."
    )
    registers: Mapping[str, Register] = Field(
        default={}, description="Registers of its encoder at power-up that differ from the profile's."
    )
