"""Verbs of a Mechaduino that begin no motion, and what it refuses, at exact simulated times."""

from typing import Any

import pytest
from mechaduino_board import BOOT_MS, DEVICE, Board

from hil.testing import Bench
from hil.vocab.verbs import VerbRefused

# ---- refusals ----


@pytest.mark.parametrize(
    ("verb", "parameters"),
    [
        ("position", {"position_deg": 10.0}),
        ("velocity", {"velocity_rpm": 10.0}),
        ("torque", {"effort_count": 10.0}),
        ("move_abs", {"position_deg": 10.0}),
        ("move_rel", {"angle_deg": 10.0}),
    ],
)
def test_nothing_moves_while_the_loop_is_off(board: Board, verb: str, parameters: dict[str, float]) -> None:
    assert board.refusal(verb, **parameters) == ("not_now", "the control loop is off; enable it first")


def test_a_position_needs_a_table_and_a_speed_does_not() -> None:
    board = Board(flash={"table": "empty"})
    board.do("enable")
    for verb, name in (("position", "position_deg"), ("move_abs", "position_deg"), ("move_rel", "angle_deg")):
        code, why = board.refusal(verb, **{name: 5.0})
        assert (code, why) == ("not_now", "the look-up table is empty; calibrate it first")
    board.do("velocity", velocity_rpm=5.0)
    assert (board.now.mode, board.now.r) == (ord("v"), 5.0)
    board.do("torque", effort_count=-3.0)
    assert (board.now.mode, board.now.r) == (ord("t"), -3.0)


AT_PROMPT = "its command {} runs, or asks for a number at its terminal"
REMEDY = "answer it there, wait for the end, or reset it"
BUSY = {
    None: "it starts, and takes commands 4 s after power-up; wait until then",
    b"c": "it calibrates itself, which takes 26 s and more; wait for the end, or reset it",
    **{letter: f"{AT_PROMPT.format(letter.decode())}; {REMEDY}" for letter in (b"a", b"r", b"k")},
}
MOVING: tuple[tuple[str, dict[str, Any]], ...] = (
    ("enable", {}),
    ("mode", {"mode": "velocity"}),
    ("position", {"position_deg": 1.0}),
    ("velocity", {"velocity_rpm": 1.0}),
    ("torque", {"effort_count": 1.0}),
    ("move_abs", {"position_deg": 1.0}),
    ("move_rel", {"angle_deg": 1.0}),
    ("calibrate", {}),
)


@pytest.mark.parametrize(("verb", "given"), MOVING, ids=[verb for verb, _ in MOVING])
@pytest.mark.parametrize("busy_with", [b"c", b"a", b"r", b"k", None], ids=str)
def test_what_the_main_program_does_is_not_disturbed(
    verb: str, given: dict[str, Any], busy_with: bytes | None
) -> None:
    bench = Bench({"bench": "t", "devices": {"m1": DEVICE}})
    if busy_with is not None:  # else it starts
        bench.run(BOOT_MS)
        bench.port("m1").write(busy_with)
        bench.run(50)
    with pytest.raises(VerbRefused) as refused:
        bench.axis("m1").do(verb, **given)
    also = "" if busy_with else "; b.start() lets it start"
    assert (refused.value.code, str(refused.value)) == ("not_now", f"m1: {BUSY[busy_with]}{also}")
    assert bench.axis("m1").do("gains")["pKp"] == 15.0


def test_a_calibration_with_the_loop_on_is_refused(on: Board) -> None:
    code, why = on.refusal("calibrate")
    assert (code, why) == ("not_now", "the control loop is on, and would turn the shaft; disable it first")


def test_relative_moves_do_not_add_up_beyond_the_range(on: Board) -> None:
    on.do("move_abs", position_deg=1e6)
    assert on.refusal("move_rel", angle_deg=1.0) == (
        "bad_parameter",
        "angle_deg: it would lead to 1000001 deg",
    )


def test_what_does_not_do_is_refused_with_every_problem(on: Board) -> None:
    code, why = on.refusal("move_abs", position_deg=2e6, velocity=5.0)
    assert code == "bad_parameter"
    assert why == (
        'velocity: there is no such parameter; did you mean "velocity_rpm"?'
        " parameters of move_abs are position_deg, velocity_rpm, acceleration_rpm_per_s;"
        " position_deg: 2000000 is too large; write -1000000 to 1000000 deg"
    )
    code, why = on.refusal("fly")
    assert code == "no_verb"
    assert why.startswith("m1 has no 'fly'; there are position, velocity, torque, mode, enable, ")
    assert on.refusal("reset")[0] == "no_verb"  # the device's face has it


def test_a_failed_and_a_hanging_board_refuse(on: Board) -> None:
    hang = on.bench.fault("node_hang", "m1")
    assert on.refusal("position", position_deg=1.0) == ("not_now", "its main program hangs")
    hang.clear()
    on.do("position", position_deg=1.0)
    on.bench.fault("node_brown_out", "m1")
    with pytest.raises(VerbRefused) as refused:
        on.do("position", position_deg=1.0)
    assert refused.value.code == "failed"


# ---- set-points ----


def test_enable_holds_the_shaft_where_it_is(board: Board) -> None:
    answer = board.do("enable")
    assert answer == {"set_point": board.now.r, "effective_at_ns": BOOT_MS * 1e6}
    before_deg = board.now.position_deg
    state = board.run(1000)
    assert (state.loop_on, state.mode) == (1, ord("x"))
    assert abs(state.position_deg - before_deg) < 0.1


@pytest.mark.parametrize("start_deg", [-0.1, 359.9, -0.02, 180.1])
def test_enable_holds_the_shaft_on_either_side_of_zero(start_deg: float) -> None:
    # The letter y takes the reading for the angle: from 359.9 the shaft turns once.
    board = Board(axis={"start_deg": start_deg})
    from_deg = board.now.position_deg
    board.do("enable")
    extremes = [board.run(1).position_deg for _ in range(500)]
    assert max(extremes) - min(extremes) < 30.0  # the law's differential term begins at 0
    assert abs(extremes[-1] - from_deg) < 0.1


def test_enable_holds_a_shaft_that_was_turned_over_zero_meanwhile() -> None:
    board = Board(axis={"start_deg": 3.0})
    board.do("enable")
    board.run(500)
    board.do("disable")
    board.axis.load_torque_Nm = -0.05
    while board.run(1).position_deg > -20:
        pass
    board.axis.load_torque_Nm = 0.0
    turned_deg = board.run(1000).position_deg
    board.do("enable")
    board.do("mode", mode="position")  # before the first control step
    extremes = [board.run(1).position_deg for _ in range(500)]
    assert max(abs(each - turned_deg) for each in extremes) < 30.0
    assert abs(extremes[-1] - turned_deg) < 0.1


def test_position_velocity_and_torque_are_set_points_of_their_modes(on: Board) -> None:
    answer = on.do("position", position_deg=90.0)
    assert answer == {"effective_at_ns": on.bench.now_ns}
    state = on.run(1000)
    assert (state.mode, state.r) == (ord("x"), 90.0)
    assert abs(state.position_deg - 90.0) < 0.1
    on.do("velocity", velocity_rpm=-60.0)
    state = on.run(1000)
    assert (state.mode, state.r) == (ord("v"), -60.0)
    assert abs(state.velocity_rpm + 60.0) < 3.0
    on.do("torque", effort_count=25.0)
    state = on.run(1)
    assert (state.mode, state.r, state.u) == (ord("t"), 25.0, 25.0)


def test_a_mode_begins_with_the_present_angle_or_with_nothing(on: Board) -> None:
    for name, letter in (("velocity", "v"), ("torque", "t")):
        on.do("position", position_deg=50.0)
        on.run(300)
        on.do("mode", mode=name)
        assert (on.now.mode, on.now.r) == (ord(letter), 0.0)
    for name, letter in (("position", "x"), ("hybrid", "h")):
        on.do("velocity", velocity_rpm=30.0)
        state = on.run(300)
        on.do("mode", mode=name)
        assert on.now.mode == ord(letter)
        assert abs(on.now.r - state.position_deg) < 0.1


def test_disable_takes_the_current_off(on: Board) -> None:
    on.do("disable")
    state = on.now
    assert (state.loop_on, state.vref1, state.vref2) == (0, 0, 0)


def test_gains_are_told_and_set(board: Board) -> None:
    told = board.do("gains")
    assert {name: round(value, 6) for name, value in told.items() if name != "effective_at_ns"} == {
        **{"pKp": 15.0, "pKi": 0.2, "pKd": 250.0, "pLPF": 30.0},
        **{"vKp": 0.001, "vKi": 0.001, "vKd": 0.0, "vLPF": 100.0},
    }
    assert board.do("gains", pKp=12.5, vLPF=50)["pKp"] == 12.5
    assert (board.now.pKp, board.now.vLPF, board.now.pKi) == (12.5, 50.0, told["pKi"])
    assert board.refusal("gains", pKp=-1.0) == ("bad_parameter", "pKp: -1 is too small; write 0 to 1000000")


def test_calibrate_types_c(board: Board) -> None:
    assert board.do("calibrate") == {"effective_at_ns": board.bench.now_ns, "ends_after_ns": 26_620_000_000}
    begun = board.port.read_timed()
    assert begun[0][0] == board.bench.now_ns
    assert begun[0][1].startswith(b"Beginning calibration")
    board.run(30000)
    assert b"Calibration complete!" in board.port.read()
