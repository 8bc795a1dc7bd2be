"""CPU cost of SACs that make step pulses at the manual's headline rate, 33.3 kHz, with driver and motor.

`python benchmarks/stepper_cost.py [--quick]`; 252 is a full segment's number of nodes.
"""

import sys
import time

from _report import check_work

from hil.compose import find_catalogue
from hil.core import Core
from hil.core.kinds.sac.core_motion import CoreMotion
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.motion import CONTINUOUS_SLOT, MotionEntry, MotionSetup

AXES = 252
PERIOD_US, EXPONENT = 480, 4  # 16 pulses of 30 us a step
PULSES_PER_S = (1 << EXPONENT) * 1_000_000 / PERIOD_US
MS_PINS = 7  # of an A4988: 16 microsteps
HORIZON_NS, SLICE_NS = 1 << 62, 1_000_000


def running(core: Core, plant: str) -> tuple[int, CoreMotion]:
    """A group with a SAC in continuous motion."""
    profile = find_catalogue().profiles["sac"]
    parameters = {name: parameter.default(plant) for name, parameter in profile.axis.items()}
    group = core.native.group_open(0)
    axis = core.open_axis(
        group, AxisPlan(parameters, "full" if plant == "full" else "simple", law=profile.law)
    )
    assert isinstance(axis, CoreMotion)
    axis.setup(MotionSetup(200, 10, EXPONENT, 1, 8, 0, True, 1_000_000, False, 36, MS_PINS))
    rpm = 300_000 // PERIOD_US
    axis.write_entry(
        CONTINUOUS_SLOT, MotionEntry(0, False, rpm, PERIOD_US, 100, 0, False, 0, False, 0, False)
    )
    axis.run_continuous()
    return group, axis


def reach(core: Core, group: int, until_ns: int) -> None:
    """Take a group to a time, past the events at which the core hands on what happened."""
    while core.native.advance(group, HORIZON_NS, until_ns)[0] < until_ns:
        core.native.take_events(group)


def main() -> None:
    seconds = 0.2 if "--quick" in sys.argv else 2.0
    for plant in ("simple", "full"):
        core = Core(AXES)
        axes = [running(core, plant) for _ in range(AXES)]
        now_ns = 3_000_000_000  # beyond the ramp
        for group, _ in axes:
            reach(core, group, now_ns)
        before = sum(axis.get("pulses") for _, axis in axes)
        began = time.process_time()
        for _ in range(round(seconds * 1000)):
            now_ns += SLICE_NS
            for group, _ in axes:
                reach(core, group, now_ns)
        cpu_s = time.process_time() - began
        pulses = sum(axis.get("pulses") for _, axis in axes) - before
        check_work(f"pulses with plant {plant}", pulses, AXES * seconds * PULSES_PER_S, 0.001)
        print(
            f"{AXES} SACs, plant {plant}: {pulses / AXES / seconds:,.0f} pulses/s each,"
            f" {cpu_s / seconds:.2f} of a core, {cpu_s / pulses * 1e9:.0f} ns a pulse"
        )


if __name__ == "__main__":
    main()
