"""Joints of an arm, in one group with one main loop: nothing that they do hangs on who looks when."""

from random import Random
from typing import Any

import pytest

from hil.core import Core
from hil.core.kinds.walter.kind import CoreJoint
from hil.vocab.axis_plan import AxisPlan

JOINT = {
    "inertia_kg_m2": 5e-5,
    "viscous_Nm_s_per_rad": 1e-3,
    "torque_constant_Nm_per_A": 0.45,
    "start_deg": 3.0,
    "load_torque_Nm": 0.0,
    "rotor_teeth": 50.0,
    "phase_current_A": 1.0,
    "gear_ratio": 9.0,
    "driver_microsteps": 8.0,
    "counts_backwards": 0.0,
    "encoder_null_deg": 143.0,
    "encoder_offset_deg": 0.0,
}
HORIZON_NS = 1 << 62
SETTINGS = {
    "set_min": -90,
    "set_max": 90,
    "set_null": 143,
    "set_speed": 100,
    "set_acceleration": 700,
    "set_p": 0.4,
}
FAULTS = (
    *(("jam", 1), ("jam", 0), ("open_a", 1), ("open_a", 0), ("noise_counts", 2), ("noise_counts", 0)),
    *(("shift_rev", 0.01), ("load_Nm", 1.0), ("load_Nm", 0), ("open_line", 1), ("open_line", 0)),
    *(("silent_rate", 0.3), ("silent_rate", 0), ("freeze", 1), ("freeze", 0)),
)


class Arm:
    """Five joints that are set up and powered."""

    def __init__(self) -> None:
        self.core, self.shown = Core(5), list[Any]()
        self.id = self.core.native.group_open(0)
        joints = [self.core.open_axis(self.id, AxisPlan(JOINT, law="walter")) for _ in range(5)]
        self.joints = [joint for joint in joints if isinstance(joint, CoreJoint)]
        self.do = self.joints[0].do
        assert self.do("start") == 0
        for joint in self.joints:
            for call, value in SETTINGS.items():
                joint.do(call, value)
            for call in ("connect", "set_up", "read", "settle", "due"):
                joint.do(call)
            joint.do("passed", 1)
            joint.do("enable", 1)
        for call in ("know", "power"):
            self.do(call, 1)
        self.do("go_on")

    def reach(self, at_ns: int) -> None:
        now_ns = -1
        while now_ns < at_ns:
            now_ns, _ = self.core.native.advance(self.id, HORIZON_NS, at_ns)
            self.shown += self.core.take_events(self.id)


def command(random: Random, arm: Arm) -> None:
    joint, what = random.choice(arm.joints), random.choice(FAULTS)
    deg, ms, kind = random.uniform(-100, 100), random.choice((20, 100, 1000)), random.randrange(9)
    if kind < 4:
        joint.do("move", deg, ms)
    elif kind < 6:
        joint.fault(*what)
    elif kind == 6:
        joint.do("enable", deg > -50)
    elif kind == 7:
        arm.do("power", deg > -50)
    else:
        arm.do(random.choice(("hold", "stop", "go_on")))
        arm.do("go_on")


def run(seed: int, looks: Random | None) -> list[Any]:
    """Everything that is shown at each command; ``looks``: chance of cuts and looks between them."""
    random, arm, then_ns = Random(seed), Arm(), 0
    for _ in range(30):
        now_ns, longest_ns = then_ns, random.choice((1, 500, 20_000, 1_000_000, 60_000_000))
        then_ns += random.randrange(longest_ns + 1)
        if looks:
            for at_ns in sorted(looks.randint(now_ns, then_ns) for _ in range(looks.choice((0, 1, 5)))):
                arm.reach(at_ns)
                looks.choice(arm.joints).snapshot()
        arm.reach(then_ns)
        command(random, arm)
        arm.shown += [joint.snapshot().as_dict() for joint in arm.joints]
    return arm.shown


@pytest.mark.parametrize("seed", range(12))
def test_neither_cuts_nor_looks_change_anything(seed: int) -> None:
    assert repr(run(seed, None)) == repr(run(seed, Random(-seed)))


def test_a_joint_that_is_not_first_has_no_loop() -> None:
    arm = Arm()
    arm.reach(1_000_000_000)
    assert arm.joints[4].do("start") == -1


def test_a_board_without_all_joints_does_not_start() -> None:
    core = Core(2)
    group = core.native.group_open(0)
    joints = [core.open_axis(group, AxisPlan(JOINT, law="walter")) for _ in range(2)]
    assert isinstance(joints[0], CoreJoint)
    assert joints[0].do("move", 10, 100) == -1
    assert joints[0].do("start") == -1
