"""Keys of one axis of a device, and the numbers that they make of its profile's."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

from hil.config.catalogue import AxisInfo
from hil.config.motor_choice import with_motor
from hil.config.shaft_load import LoadConfig


class AxisKeys(NamedTuple):
    """Keys of an axis: its own, over the device's. As ``AxisConfig``, whose values are checked already."""

    plant: Literal["simple", "full"]
    motor: str | None
    load: LoadConfig | None
    axis: Mapping[str, float]
    registers: Mapping[str, int]


def axis_parameters(own: AxisKeys, info: AxisInfo) -> dict[str, float]:
    """Numbers of an axis: those, its own over them, with the friction of its load."""
    numbers = usual_axis_parameters(own, info) | dict(own.axis)
    return own.load.with_friction(numbers) if own.load else numbers


def usual_axis_parameters(own: AxisKeys, info: AxisInfo) -> dict[str, float]:
    """Numbers of an axis without its own: the profile's for its plant, with those of its motor."""
    numbers = {key: each.default(str(own.plant)) for key, each in info.axis.items()}
    return with_motor(numbers, own.motor, str(own.plant), info.law) if own.motor else numbers
