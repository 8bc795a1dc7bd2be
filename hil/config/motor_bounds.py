"""Bounds of the numbers of a motor and what it turns, by the motor's own figures.

``docs/decisions/0034-bounds-of-motors.md`` has the table with its reasons.
"""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from hil.core.kinds import KINDS
from hil.sim.load_limit import AS_SHOWN, load_problem
from hil.vocab.axis_plan import AxisPlan, Load
from hil.vocab.faults import MOST_LOADS

TIMES = 100.0
"""Factor by which another motor may differ from the profile's: units of a thousandth differ by more."""
OF_OTHER_MOTORS = (
    "torque_constant_Nm_per_A",
    *dict.fromkeys(filter(None, (kind.current_parameter for kind in KINDS.values()))),
    "phase_resistance_ohm",
    "phase_inductance_H",
)
"""Parameters that are bound by ``TIMES``. The torque and the speed of coils follow from them."""
STARTED_rad_per_s, START_S = math.tau, 1.0
"""Speed that a motor's torque gives to all that turns, and in what time: 60 rpm."""
SLOWEST_rad_per_s = math.tau / 60
"""Speed that a motor's torque keeps against its viscous friction at least: 1 rpm."""


BOUNDS = {
    ("inertia_kg_m2", "load"): (
        f"together above 0, and at most what the motor's torque brings to 60 rpm in {START_S:g} s",
        "with more nothing turns in the time of a test; a flywheel of thousands of rotors is still less",
    ),
    ("viscous_Nm_s_per_rad",): (
        "0 to what the motor's torque turns at 1 rpm",
        "with more the shaft stands: `shaft_jam` is the fault for that",
    ),
    ("coulomb_torque_Nm", "load_torque_Nm", "load", "shaft_load"): (
        f"up to {MOST_LOADS} times what the motor holds; those that push the same way together",
        "two drag the motor along, ten leave room for knocks",
    ),
    ("detent_torque_Nm",): ("0 to what the motor holds", "with more the coils do not turn the rotor"),
    OF_OTHER_MOTORS: (
        f"the profile's figure, and {TIMES:g} times less or more",
        "another motor or resistor; mH for H or mNm for Nm are a thousand times more",
    ),
}
"""Bounds of parameters, of the key `load` and of the fault `shaft_load`: each with its reason. What a motor
holds is its torque constant times the largest current of a coil."""


class Beyond(NamedTuple):
    """A number that is out of its bounds. ``key`` is its path below the axis's keys."""

    key: tuple[str, ...]
    what: str
    remedy: str


def numbers_beyond(plan: AxisPlan, usual: Mapping[str, float]) -> Iterator[Beyond]:
    """Numbers of an axis that are out of their bounds. ``usual``: the profile's parameters for this plant."""
    yield from (beyond := [*_other_units(plan.parameters, usual)])
    if beyond:  # what follows is reckoned with them
        return
    holding_Nm = KINDS[plan.law].holding_Nm(plan.parameters)
    yield from _inertia_beyond(plan, holding_Nm)
    most = {
        "viscous_Nm_s_per_rad": (holding_Nm / SLOWEST_rad_per_s, "with more this motor turns less than 1 rpm")
    }
    if plan.plant == "full":
        most["coulomb_torque_Nm"] = (
            MOST_LOADS * holding_Nm,
            f"{MOST_LOADS} times what this motor holds ({holding_Nm:g} Nm)",
        )
        most["detent_torque_Nm"] = (holding_Nm, "what this motor holds: with more its coils do not turn it")
    for name, (limit, why) in most.items():
        if not 0 <= (value := plan.parameters[name]) <= limit * (1 + AS_SHOWN):
            yield Beyond(("axis", name), f"{value:g} is out of bounds", f"write 0 to {limit:g}: {why}")


def _other_units(parameters: Mapping[str, float], usual: Mapping[str, float]) -> Iterator[Beyond]:
    for name in OF_OTHER_MOTORS:
        if name not in parameters:
            continue
        value, figure = parameters[name], usual[name]
        low, high = figure / TIMES, figure * TIMES
        if not 0 < value < math.inf:
            yield Beyond(("axis", name), f"{value:g} is out of bounds", "write more than 0")
        elif not low * (1 - AS_SHOWN) <= value <= high * (1 + AS_SHOWN):
            yield Beyond(
                ("axis", name),
                f"{value:g} is out of bounds",
                f"write {low:g} to {high:g}: the profile's {figure:g}, and {TIMES:g} times less or more;"
                " what is beyond has another unit",
            )


def _inertia_beyond(plan: AxisPlan, holding_Nm: float) -> Iterator[Beyond]:
    rotor_kg_m2, limit_kg_m2 = plan.parameters["inertia_kg_m2"], holding_Nm * START_S / STARTED_rad_per_s
    load_kg_m2 = plan.load.inertia_kg_m2 if plan.plant == "full" else 0.0
    why = f"with more this motor's {holding_Nm:g} Nm need over {START_S:g} s to 60 rpm"
    if not 0 < rotor_kg_m2 <= limit_kg_m2 * (1 + AS_SHOWN):
        what = f"{rotor_kg_m2:g} kg m2 is out of bounds"
        yield Beyond(
            ("axis", "inertia_kg_m2"), what, f"write more than 0, and {limit_kg_m2:g} or less: {why}"
        )
    elif not rotor_kg_m2 + load_kg_m2 <= limit_kg_m2 * (1 + AS_SHOWN):
        what = f"the load has {load_kg_m2:g} kg m2 of inertia"
        remedy = f"make it {limit_kg_m2 - rotor_kg_m2:g} or less, from all its numbers: {why}"
        yield Beyond(("load",), what, remedy)


def pulls_beyond(plan: AxisPlan) -> Iterator[tuple[str, str]]:
    """Messages and remedies for a load that pulls more than a motor may be pulled."""
    holding_Nm = KINDS[plan.law].holding_Nm(plan.parameters)
    most_Nm = MOST_LOADS * holding_Nm
    for what, torque_Nm in _pulls(plan.load, plan.parameters["start_deg"]):
        if load_problem(torque_Nm, holding_Nm):
            times = f"{MOST_LOADS} times what this motor holds ({holding_Nm:g} Nm)"
            yield f"{what} pulls with {abs(torque_Nm):g} Nm", f"make it {most_Nm:g} Nm or less, {times}"


def _pulls(load: Load, start_deg: float) -> Iterator[tuple[str, float]]:
    yield "the pendulum", load.pendulum_Nm
    yield "the carriage's weight", load.torque_Nm
    stretched_rad = math.radians(start_deg - load.centre_deg)
    yield "where the shaft starts, the spring", load.stiffness_Nm_per_rad * stretched_rad
