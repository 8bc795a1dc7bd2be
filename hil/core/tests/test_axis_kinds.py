"""The table of kinds of axis, against what the native core does."""

import ast
from array import array
from pathlib import Path

import pytest

from hil.core import KINDS, Core, CoreAxis
from hil.core.abi import TABLE_LEN, Law
from hil.core.axis_kind import ANGLE
from hil.core.axis_kind import MOTOR as MOTOR_PARAMETERS
from hil.core.fields import FIELDS
from hil.core.kinds.mechaduino.kind import KIND as MECHADUINO
from hil.core.kinds.sac.core_motion import CoreMotion
from hil.core.kinds.sac.kind import KIND as SAC
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.motion import CONTINUOUS_SLOT, MotionEntry
from hil.vocab.path import PathPiece

HIL = Path(__file__).parent.parent.parent
MOTOR = {
    "inertia_kg_m2": 5.7e-6,
    "viscous_Nm_s_per_rad": 1e-4,
    "torque_constant_Nm_per_A": 0.2,
    "start_deg": 0.0,
    "load_torque_Nm": 0.0,
    "rotor_teeth": 50.0,
    "sense_resistor_ohm": 0.15,
    "phase_current_A": 1.5,
    "driver": 0.0,
    "gear_ratio": 9.0,
    "driver_microsteps": 8.0,
    "counts_backwards": 0.0,
    "encoder_null_deg": 143.0,
    "encoder_offset_deg": 0.0,
    "ambient_degC": 25.0,
    "fast_decay_pct": 39.0,
}
HORIZON_NS = 1 << 62


class Bench:
    """One axis alone."""

    def __init__(self, law: str) -> None:
        self.core = Core(1)
        self.group = self.core.native.group_open(0)
        self.axis: CoreAxis = self.core.open_axis(self.group, AxisPlan(MOTOR, law=law))

    def motion(self, at_ms: int = 0):
        self.core.native.advance(self.group, HORIZON_NS, at_ms * 1_000_000)
        return self.axis.kind.motion(self.axis.snapshot())


@pytest.mark.parametrize("law", Law.__members__)
def test_every_law_has_a_row_whose_fields_it_has(law: str) -> None:
    kind = KINDS[law]
    assert kind.law == Law[law]
    assert {*kind.default_signals, *kind.course} <= kind.fields.keys() < FIELDS.keys()
    axis = Bench(law).axis
    assert axis.kind is kind
    assert axis.snapshot().as_dict().keys() == kind.fields.keys()
    assert kind.inputs.keys() == axis.pins.keys()
    for name in kind.inputs:
        axis.pin(name, 0)


def test_two_names_are_the_same_pin() -> None:
    assert [MECHADUINO.inputs[name] for name in ("D0", "D1", "D2", "D3", "dir", "step", "enable")] == [
        *(0, 1, 2, 3),
        *(0, 1, 2),
    ]


def test_a_motor_holds_what_its_largest_current_gives() -> None:
    assert MECHADUINO.holding_Nm(MOTOR) == pytest.approx(0.2 * 0.33 / 0.15)
    assert SAC.holding_Nm(MOTOR) == pytest.approx(0.2 * 1.5)


def test_a_servo_whose_loop_is_off_is_off() -> None:
    motion = Bench("mechaduino").motion(1)
    assert (motion.is_on, motion.is_moving, motion.keeps_angle) == (False, False, False)


def test_a_servo_that_follows_a_path_is_under_way() -> None:
    bench = Bench("mechaduino")
    bench.axis.loop(True)
    bench.axis.set("mode", ord("x"))
    assert (bench.motion(1).keeps_angle, bench.motion(1).is_moving) == (True, False)
    bench.axis.follow([PathPiece(20_000_000, 0.0, 100.0, 0.0, 0.0)])
    assert (bench.motion(10).is_under_way, bench.motion(10).is_moving) == (True, True)
    assert bench.motion(11).commanded_deg == pytest.approx(1.0, abs=0.03)
    assert (bench.motion(30).is_under_way, bench.motion(30).commanded_deg) == (False, pytest.approx(2.0))


def test_a_servo_that_turns_moves_without_an_end() -> None:
    bench = Bench("mechaduino")
    bench.axis.write_table(array("f", [i * 360 / TABLE_LEN for i in range(TABLE_LEN)]).tobytes())
    bench.axis.loop(True)
    bench.axis.set("mode", ord("t"))
    assert not bench.motion(1000).is_moving
    bench.axis.set("r", 100.0)
    motion = bench.motion(1200)
    assert (motion.is_moving, motion.is_under_way, motion.keeps_angle) == (True, False, False)


def test_a_stepper_with_a_motion_is_moving() -> None:
    bench = Bench("sac")
    axis = bench.axis
    assert isinstance(axis, CoreMotion)
    assert (bench.motion(1).is_on, bench.motion(1).is_moving) == (True, False)
    entry = MotionEntry(0, False, 60, 5000, 0, 0, False, 0, False, 0, False)
    axis.write_entry(CONTINUOUS_SLOT, entry)
    axis.run_continuous()
    assert (bench.motion(100).is_moving, bench.motion(100).is_under_way) == (True, True)
    assert bench.motion(100).commanded_deg != 0.0
    axis.stop(None)
    assert (bench.motion(101).is_moving, bench.motion(101).is_under_way) == (False, False)


def test_only_some_axes_are_motion_engines() -> None:
    assert not isinstance(Bench("mechaduino").axis, CoreMotion)
    assert isinstance(Bench("sac").axis, CoreMotion)


def test_a_law_without_calls_of_its_own_answers_none() -> None:
    axis = Bench("a3967").axis
    assert axis._native.do(axis.id, 0, 0.0, 0.0, 0.0) == -1
    servo = Bench("mechaduino").axis
    assert servo._native.do(servo.id, 99, 0.0, 0.0, 0.0) == -1


WORDS = {*KINDS} | {
    name
    for kind in KINDS.values()
    for name in (*kind.parameters, *kind.settable)
    if name not in (*MOTOR_PARAMETERS, ANGLE)
}
"""Names of laws, and of the parameters and settable fields that only some kinds have."""
OF_THE_KIT = {"control.py", "faces.py", "live_axes.py", "plugin.py"}
"""Modules of the test kit that name a board or a register for those who test one."""
OF_PROFILES = {"board_processor.py"}
"""Modules with keys of a ``profile.yaml``, one of which is called as a field is: a processor's clock_Hz."""
MODULES = {f"hil.core.kinds.{law}" for law in KINDS}


def law_questions(text: str) -> list[int]:
    """Lines that compare a ``.law``, import a kind's own module, the core's laws or the field table's kinds,
    or have a word of ``WORDS``."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module == "hil.core.abi":
            found += [node.lineno for each in node.names if each.name in ("Law", "Kind")]
        if isinstance(node, ast.ImportFrom) and node.module:
            found += [node.lineno] * (".".join(node.module.split(".")[:4]) in MODULES)
        if isinstance(node, ast.Compare) and not isinstance(node.ops[0], ast.In | ast.NotIn):
            sides = (node.left, node.comparators[0])
            is_law = any(isinstance(side, ast.Attribute) and side.attr == "law" for side in sides)
            is_none = any(isinstance(side, ast.Constant) and side.value is None for side in sides)
            found += [node.lineno] * (is_law and not is_none)
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found += [node.lineno] * (node.value in WORDS)
    return found


@pytest.mark.long
def test_no_module_asks_for_a_law_beside_the_kinds_own() -> None:
    kinds, of_the_form = (
        HIL / "core/kinds",
        {"abi.py", "axis_kind.py", "fields.py"} | OF_THE_KIT | OF_PROFILES,
    )
    files = [file for file in HIL.rglob("*.py") if "tests" not in file.parts and file.name not in of_the_form]
    files = [file for file in files if not file.is_relative_to(kinds)]
    assert {file.name: lines for file in files if (lines := law_questions(file.read_text()))} == {}


@pytest.mark.parametrize(
    "line",
    [
        'is_servo = plan.law == "servo"',
        "is_servo = axis.kind.law is SERVO.law",
        "from hil.core.abi import Law",
        "from hil.core.kinds.sac.kind import KIND",
        'SETTABLE = ("clock_Hz",)',
        'law: str = "mechaduino"',
    ],
)
def test_a_planted_question_is_found(line: str) -> None:
    assert set(law_questions(line)) == {1}


def test_a_kind_is_a_folder() -> None:
    folders = {file.parent.name for file in (HIL / "core/kinds").glob("*/kind.py")}
    assert folders == KINDS.keys() == Law.__members__.keys()
