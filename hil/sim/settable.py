"""Values of fields of an axis that are set from outside, by whatever way: commands, bridges, faults."""

from typing import TYPE_CHECKING

from hil.core.axis_kind import ANGLE, LOAD, Settable
from hil.vocab.own_fields import OwnField
from hil.vocab.parameters import Parameter
from hil.vocab.typed_numbers import unit_in

if TYPE_CHECKING:  # who only reads the names starts quickly
    from collections.abc import Callable

    from hil.core import CoreAxis, Snapshot
    from hil.sim.faults.in_force import Faults
    from hil.sim.twin import Twin


def setting_problem(
    faults: "Faults",
    device: "Twin",
    name: str,
    value: object,
    part: str = "",
    look: "Callable[[], Snapshot] | None" = None,
) -> str | None:
    """Error text for a value of a field of an axis (``AxisKind.settable``), or None. ``part``: the axis's
    name; empty: the device's first. ``look``: takes its state now; None: the caller has its group."""
    axis = device.axes[part]
    if name not in axis.kind.fields:
        if name == ANGLE:
            return f"{device.name}, a {device.profile}, has no motor; `hil list` shows the others"
        return f"{device.name}, a {device.profile}, has no {name}"
    if name == LOAD:
        problem = faults.load_problem(axis, value)
        return problem and f"{name}: {problem}"
    if name == ANGLE and (problem := _zero_problem(axis, look or axis.snapshot)):
        return f"{name}: {problem}"
    if own := axis.kind.board_fields.get(name):
        return _own_problem(own, value)
    low, high = _range(device, name, axis.kind.settable.get(name, Settable()))
    problem = Parameter(name, "", unit_in(name), low, high).problem(value)
    return problem and f"{name}: {problem}"


def _own_problem(own: OwnField, value: object) -> str | None:
    """Reason why a board's own field cannot have a value, or None."""
    row = Parameter(own.name, "", unit_in(own.name), own.low, own.high, is_whole=own.is_whole)
    problem = row.problem(value) or own.refusal(float(str(value)))
    return problem and f"{own.name}: {problem}"


def _zero_problem(axis: "CoreAxis", look: "Callable[[], Snapshot]") -> str | None:
    """Reason why the zero of an axis's angle stays where it is, or None."""
    if axis.is_on_bus:
        return "masters of the CAN bus count by it; let them home the drive (607Ch, 6098h)"
    if axis.is_in_run:
        return "a run goes by it; cancel it, or wait for its end"
    if not axis.kind.follows_paths and axis.kind.motion(look()).is_under_way:
        return "its motions end at angles; wait until it stands"
    return None


def _range(device: "Twin", name: str, usual: Settable) -> tuple[float, float]:
    """Range of a field; a gain has the limits of the board's verb."""
    gains = device.verbs["gains"].parameters if "gains" in device.verbs else ()
    for parameter in gains:
        if parameter.name == name:
            return parameter.minimum, parameter.maximum
    return usual.low, usual.high
