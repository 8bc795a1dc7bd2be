"""Time in which a coil's current is turned round, and the speed that it allows.

A supply V changes the current of a coil with the inductance L by V / L amperes a second. From -I to I it
takes 2 L I / V: no full step should be shorter. Source: the manual, which has it from a calculator of stepper
speeds.
"""

from collections.abc import Sequence

from hil.vocab.axis_plan import AxisPlan

MICROSTEPS = 8
"""Microsteps of a full step with MS1 and MS2 as the board pulls them."""


def reversal_us(inductance_H: float, current_A: float, supply_V: float) -> float:
    """Compute the time for the reversal of a coil's current in microseconds: that of a full step."""
    return 2e6 * inductance_H * current_A / supply_V


def says(plan: AxisPlan) -> Sequence[str]:
    """Say how fast the configured motor can be stepped."""
    of = plan.parameters
    coil = (of["phase_inductance_H"], of["phase_current_A"], of["supply_V"])
    full_us = reversal_us(*coil)
    full_Hz, rpm = 1e6 / full_us, 60e6 / (4 * of["rotor_teeth"] * full_us)
    inductance_H, current_A, supply_V = coil
    return [
        f"{supply_V:g} V reverse {current_A:g} A in {inductance_H * 1e3:g} mH in {full_us / 1e3:.4g} ms:"
        f" up to {full_Hz:.4g} full steps/s, {MICROSTEPS * full_Hz:.5g} eighth steps/s"
        f" (one each {full_us / MICROSTEPS:.4g} us), {rpm:.4g} rpm",
        *([] if plan.plant == "full" else ["the simple plant knows no inductance: it does not stall there"]),
    ]
