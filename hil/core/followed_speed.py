"""Speed up to which a motor follows what it is told, by its figures.

The simple plant has the same torque at each speed: the motor follows until friction and load take all of it.
The full plant drives the coils by its supply. Up to some speed that is enough for the whole current: for its
resistance, for the voltage that the rotor induces, and across from both for the inductance. Above that speed
the torque falls, and at another there is none left, where a square wave of the supply drives what friction
and load take. Between the two it depends on ramps and resonances whether steps are lost.
docs/decisions/0008-full-plant.md has the equations.
"""

from collections.abc import Callable, Mapping
from math import hypot, pi

from hil.core.axis_kind import speed_limit_rpm
from hil.core.kinds import KINDS
from hil.vocab.axis_plan import AxisPlan, FollowedSpeed

SQUARE = 4 / pi
"""Amplitude of the sine in a square wave, which a chopper that cannot follow makes of the supply."""
_HALVINGS = 40


def followed_speed(plan: AxisPlan) -> FollowedSpeed:
    """Compute the speeds. They are bounds: resonances of full steps, and ramps that are too steep, lose steps
    below them."""
    kind = KINDS.get(plan.law)
    if kind is None or not kind.has_motor:
        return FollowedSpeed()
    amps, of = kind.max_current_A(plan.parameters), plan.parameters
    last_rpm = _highest_rpm(of, lambda rad_per_s: _spare_Nm(plan, amps, rad_per_s) >= 0)
    if plan.plant != "full":
        return FollowedSpeed(last_rpm, last_rpm)
    return FollowedSpeed(
        min(_highest_rpm(of, lambda speed: _wanted_V(of, amps, speed) <= of["supply_V"]), last_rpm), last_rpm
    )


def _highest_rpm(of: Mapping[str, float], is_met: Callable[[float], bool]) -> float:
    """Highest speed at which a condition on the speed in rad/s is met that is met by all lower ones."""
    low, limit_rpm = 0.0, speed_limit_rpm(of)
    high = limit_rpm * 2 * pi / 60
    if is_met(high):
        return limit_rpm
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if is_met(middle) else (low, middle)
    return low * 60 / (2 * pi)


def _wanted_V(of: Mapping[str, float], amps: float, rad_per_s: float) -> float:
    """Voltage that drives the whole current at a speed."""
    along_V = amps * of["phase_resistance_ohm"] + of["torque_constant_Nm_per_A"] * rad_per_s
    return hypot(along_V, of["rotor_teeth"] * rad_per_s * of["phase_inductance_H"] * amps)


def _spare_Nm(plan: AxisPlan, amps: float, rad_per_s: float) -> float:
    """Torque that is left of a motor's at a speed."""
    of = plan.parameters
    load_Nm = abs(of["load_torque_Nm"]) + of["viscous_Nm_s_per_rad"] * rad_per_s
    torque_Nm = of["torque_constant_Nm_per_A"] * amps
    if plan.plant == "full":
        load_Nm += of["coulomb_torque_Nm"] + abs(plan.load.torque_Nm)
        torque_Nm = min(torque_Nm, _fed_Nm(of, rad_per_s))
    return torque_Nm - load_Nm


def _fed_Nm(of: Mapping[str, float], rad_per_s: float) -> float:
    """Largest torque that the supply makes at a speed."""
    ohm, constant = of["phase_resistance_ohm"], of["torque_constant_Nm_per_A"]
    impedance = hypot(ohm, of["rotor_teeth"] * rad_per_s * of["phase_inductance_H"])
    return constant * (SQUARE * of["supply_V"] / impedance - constant * rad_per_s * ohm / impedance**2)
