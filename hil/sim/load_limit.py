"""Limit of the torque on a shaft, for the configuration, commands and faults; text about a shaft that a load
drags."""

import math
from collections.abc import Iterable, Iterator, Mapping

from hil.core import CoreAxis
from hil.core.motor_words import blocked_note, heat_note, stall_note
from hil.vocab.faults import MOST_LOADS
from hil.vocab.typed_numbers import number_problem, quoted

AS_SHOWN = 1e-5
"""Share by which a number may be beyond a limit, which messages round to six digits."""


def load_problem(torque_Nm: object, holding_Nm: float, others_Nm: Iterable[float] = ()) -> str | None:
    """Error text for a torque on the shaft of a motor that holds ``holding_Nm``, beside others that are or
    will be there; or None.

    Torques that push the same way add up to the limit at most. One that pushes the other way does not count:
    it may end first.
    """
    most_Nm = MOST_LOADS * holding_Nm
    words = (
        f"write {-most_Nm:g} to {most_Nm:g}, {MOST_LOADS} times what this motor holds"
        f" ({holding_Nm:g} Nm): a larger torque only spins it"
    )
    if isinstance(torque_Nm, str):
        return "; ".join(number_problem(torque_Nm, "Nm", words.removeprefix("write ")))
    if isinstance(torque_Nm, bool) or not isinstance(torque_Nm, int | float):
        return f"{quoted(torque_Nm)} is no number; {words}"
    beside_Nm = math.fsum(other_Nm for other_Nm in others_Nm if other_Nm * torque_Nm > 0)
    sum_Nm = beside_Nm + torque_Nm
    if abs(sum_Nm) <= most_Nm or math.isclose(abs(sum_Nm), most_Nm, rel_tol=AS_SHOWN):
        return None
    return (
        f"with {beside_Nm:g} Nm that push the same way it is {sum_Nm:g}; in all {words}"
        if beside_Nm
        else f"{quoted(torque_Nm)} is too {'small' if torque_Nm < 0 else 'large'}; {words}"
    )


def motor_notes(shot: Mapping[str, float], axis: CoreAxis) -> Iterator[str]:
    """Notes on an axis's fields ``shot``, for the operator: a load that is more than the motor holds, a shaft
    at its largest speed, a speed that the motor cannot follow, steps that it has lost, and a driver that is
    too hot."""
    holding_Nm, speed_limit_rpm = axis.holding_Nm, axis.speed_limit_rpm
    asked_rpm = abs(shot.get(axis.kind.commanded_rpm, 0.0))
    if asked_rpm and asked_rpm > (last_rpm := axis.followed.last_rpm):
        yield f"{asked_rpm:g} rpm are more than the motor follows, {last_rpm:.0f} rpm by its figures"
    yield from filter(None, (stall_note(shot, axis), blocked_note(shot, axis), heat_note(shot)))
    load_Nm, speed_rpm = shot["load_torque_Nm"], shot["velocity_rpm"]
    if abs(load_Nm) > holding_Nm and not math.isclose(abs(load_Nm), holding_Nm, rel_tol=AS_SHOWN):
        yield f"the load of {load_Nm:g} Nm is more than the motor holds ({holding_Nm:g} Nm)"
    if abs(speed_rpm) > speed_limit_rpm or math.isclose(abs(speed_rpm), speed_limit_rpm):
        yield f"the shaft turns at {speed_rpm:.0f} rpm, the limit of its model"
