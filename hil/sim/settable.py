"""Fields of an axis that may be set from outside, by whatever way: commands, bridges, faults."""

from typing import TYPE_CHECKING

from hil.vocab.parameters import plain

if TYPE_CHECKING:  # who only reads the names starts quickly
    from collections.abc import Callable

    from hil.core import CoreAxis, Snapshot
    from hil.sim.device import Device
    from hil.sim.faults.in_force import Faults

ANGLE = "position_deg"
"""Angle of the shaft as it is told: setting it sets its zero, and turns nothing."""
SURROUNDINGS = ("load_torque_Nm", "diaagc", "errfl", "knob_counts", "has_lights", ANGLE)
"""Fields that are the world around the board and not the firmware's memory."""
SETTABLE = (*SURROUNDINGS, "clock_Hz", "pKp", "pKi", "pKd", "pLPF", "vKp", "vKi", "vKd", "vLPF", "PA", "uMAX")
_RANGES = {
    "uMAX": (0.0, 255.0),
    "PA": (-360.0, 360.0),
    "clock_Hz": (-1.0, 1e9),
    "knob_counts": (0.0, 1023.0),
    "has_lights": (0.0, 1.0),
    "diaagc": (0.0, float(0x7FFF)),
    "errfl": (0.0, float(0x7FFF)),
}
_FIELD_LIMIT = 1e6


def setting_problem(
    faults: "Faults",
    device: "Device",
    name: str,
    value: object,
    part: str = "",
    look: "Callable[[], Snapshot] | None" = None,
) -> str | None:
    """Error text for a value of a field of ``SETTABLE`` of one of a device's axes, or None. ``part``: the
    axis's name; empty: the first. ``look``: takes the axis's state now; None: the caller has its group."""
    axis = device.axes[part]
    if name not in axis.kind.fields:
        return f"{device.name}, a {device.profile}, has no {name}"
    if name == "load_torque_Nm":
        problem = faults.load_problem(axis, value)
        return problem and f"{name}: {problem}"
    if name == ANGLE and (problem := _zero_problem(axis, look or axis.snapshot)):
        return f"{name}: {problem}"
    low, high = _range(device, name)
    return None if _is_between(low, value, high) else f"{name}: write {plain(low)} to {plain(high)}"


def _zero_problem(axis: "CoreAxis", look: "Callable[[], Snapshot]") -> str | None:
    """Reason why the zero of an axis's angle stays where it is, or None."""
    if axis.is_on_bus:
        return "masters of the CAN bus count by it; let them home the drive (607Ch, 6098h)"
    if axis.is_in_run:
        return "a run goes by it; cancel it, or wait for its end"
    if not axis.kind.follows_paths and axis.kind.motion(look()).is_under_way:
        return "its motions end at angles; wait until it stands"
    return None


def _range(device: "Device", name: str) -> tuple[float, float]:
    """Range of a field; a gain has the limits of the board's verb."""
    gains = device.verbs["gains"].parameters if "gains" in device.verbs else ()
    for parameter in gains:
        if parameter.name == name:
            return parameter.minimum, parameter.maximum
    return _RANGES.get(name, (-_FIELD_LIMIT, _FIELD_LIMIT))


def _is_between(low: float, value: object, high: float) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and low <= value <= high
