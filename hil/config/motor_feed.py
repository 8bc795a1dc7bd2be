"""Checks of a motor of the catalogue at its driver: whether the driver can feed it, and it bears that."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from hil.config.catalogue import ProfileInfo
from hil.config.motor_bounds import Beyond
from hil.config.motors import MOTORS
from hil.core.axis_kind import AxisKind
from hil.core.kinds import KINDS
from hil.sim.load_limit import AS_SHOWN

if TYPE_CHECKING:
    from hil.config.model import DeviceConfig

STEPS = "spr"
"""Parameter of a build that says for which motor it is: any other can be put on as well, as on the desk."""
TOO_MUCH = 1.5
"""Share of the rated current that a motor bears for some seconds; QSH5718 data sheet, table 6.1."""


def unfed(device: "DeviceConfig", profile: ProfileInfo, axis: str) -> Iterator[Beyond]:
    """Findings of an axis with a motor of the catalogue: key, message, remedy."""
    own, info = device.axis_config(profile, axis), profile.axes[axis]
    teeth = device.axis_parameters(profile, axis).get("rotor_teeth")
    kind = KINDS[info.law]
    steps = kind.steps_per_turn if STEPS not in profile.parameters else 0
    numbers = device.axis_parameters(profile, axis)
    given_A, is_own = kind.max_current_A(numbers), kind.current_parameter in own.axis
    most_A = kind.driver_A(numbers) if kind.driver_A else kind.max_current_A(numbers)
    fitting = [
        name
        for name, each in MOTORS.items()
        if (not steps or each.steps == steps)
        and max(each.rated_A, given_A if is_own else 0.0) <= most_A
        and (given_A if is_own else 0.0 if kind.driver_A else most_A) <= TOO_MUCH * each.rated_A
    ]
    if steps and teeth is not None and 4 * teeth != steps:
        key = ("axis", "rotor_teeth") if "rotor_teeth" in own.axis else ("motor",)
        of = f"motors of {steps} steps a turn"
        what = f"a {profile.name} commutates {of}, and this one has {4 * teeth:g}"
        remedy = f"write {steps // 4}" if key[0] == "axis" else f"write one of {', '.join(fitting)}"
        yield Beyond(key, what, remedy)
    if own.motor is None:
        return
    motor = MOTORS[own.motor]
    where = ("axis", kind.current_parameter) if is_own else ("motor",)
    if given_A > most_A * (1 + AS_SHOWN) or (not is_own and motor.rated_A > most_A * (1 + AS_SHOWN)):
        what = (
            f"the driver gives {most_A:g} A at most, and {_wanted(own.motor, motor.rated_A, given_A, is_own)}"
        )
        less = f"axis.{kind.current_parameter}: {most_A:g}, with which it is weaker" if kind.driver_A else ""
        yield Beyond(where, what, _remedy(kind, less, "that it can feed", fitting))
    elif given_A > TOO_MUCH * motor.rated_A:
        what = f"the driver gives it {given_A:g} A, and {own.motor} is rated for {motor.rated_A:g} A"
        less = f"axis.{kind.current_parameter}: {motor.rated_A:g}" if kind.driver_A else ""
        yield Beyond(where, what, _remedy(kind, less, "that bears it", fitting))
    supply_V, ohm = numbers.get("supply_V", 0.0), numbers.get("phase_resistance_ohm", 0.0)
    if device.axis_config(profile, axis).plant == "full" and given_A * ohm > supply_V:
        what = f"{supply_V:g} V drive {supply_V / ohm:.3g} A through {ohm:g} ohm, and {given_A:g} A are set"
        key = ("axis", "supply_V") if "supply_V" in own.axis else where
        yield Beyond(key, what, f"write axis.supply_V: {given_A * ohm:.3g} or more, or a smaller current")


def _remedy(kind: AxisKind, less: str, which: str, motors: Sequence[str]) -> str:
    """Remedy of a motor that does not go with its driver. ``less``: another current, empty: the driver has
    none that can be set; ``motors``: those of the catalogue that do."""
    fitting = f"a motor {which}: {', '.join(motors)}" if motors else ""
    return f"write {', or '.join(filter(None, (less, fitting))) or f'another axis.{kind.current_parameter}'}"


def _wanted(name: str, rated_A: float, given_A: float, is_own: bool) -> str:
    return f"{given_A:g} A are written here" if is_own else f"{name} is rated for {rated_A:g} A"
