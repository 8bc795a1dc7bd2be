"""What can be asked of a Mechaduino beside typing: each verb, at exact simulated times."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import pytest

from hil.core import Snapshot
from hil.testing import Bench
from hil.vocab.verbs import VerbRefused

DEVICE: dict[str, Any] = {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}
BOOT_MS = 4500.0
RPM = 6.0
"""Degrees by the second."""


class Board:
    """A board that has started."""

    def __init__(self, **device: Any) -> None:
        self.bench = Bench({"bench": "t", "devices": {"m1": DEVICE | device}})
        self.axis = self.bench.axis("m1")
        self.port = self.bench.port("m1")
        self.device = self.bench.device("m1")
        self.run(BOOT_MS)
        self.port.read()

    def run(self, ms: float) -> Snapshot:
        self.bench.run(ms)
        assert self.device.failed is None
        return self.now

    @property
    def now(self) -> Snapshot:
        return self.axis.snapshot()

    def do(self, verb: str, **parameters: float | str) -> dict[str, Any]:
        return self.axis.do(verb, **parameters)

    def typed(self, data: bytes, ms: float = 200) -> bytes:
        self.port.write(data)
        self.run(ms)
        return self.port.read()

    def refusal(self, verb: str, **parameters: float | str) -> tuple[str, str]:
        before = self.now
        with pytest.raises(VerbRefused) as refused:
            self.do(verb, **parameters)
        assert self.now == before  # what is refused changes nothing
        return refused.value.code, str(refused.value)


@pytest.fixture
def board() -> Iterator[Board]:
    made = Board()
    yield made
    made.bench.close()


@pytest.fixture
def on(board: Board) -> Board:
    """Its loop holds the shaft."""
    board.do("enable")
    board.run(500)
    return board


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


def test_a_verb_is_carried_out_during_the_start_up_too() -> None:
    bench = Bench({"bench": "t", "devices": {"m1": DEVICE}})
    assert bench.axis("m1").do("gains")["effective_at_ns"] == 0
    bench.axis("m1").do("enable")
    bench.run(BOOT_MS)
    assert bench.axis("m1").snapshot().loop_on == 1
    assert b"Main menu" in bench.port("m1").read()


def test_what_does_not_do_is_refused_with_every_problem(on: Board) -> None:
    code, why = on.refusal("move_abs", position_deg=2e6, velocity=5.0)
    assert code == "bad_parameter"
    assert why == (
        "velocity: parameters of move_abs are position_deg, velocity_rpm, acceleration_rpm_per_s;"
        " position_deg: write -1e+06 to 1e+06"
    )
    code, why = on.refusal("fly")
    assert code == "no_verb"
    assert why.startswith("there is no 'fly' here; there are position, velocity, torque, mode, enable, ")
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
    assert board.refusal("gains", pKp=-1.0) == ("bad_parameter", "pKp: write 0 to 1e+06")


def test_calibrate_types_c(board: Board) -> None:
    assert board.do("calibrate") == {"effective_at_ns": board.bench.now_ns}
    begun = board.port.read_timed()
    assert begun[0][0] == board.bench.now_ns
    assert begun[0][1].startswith(b"Beginning calibration")
    board.run(30000)
    assert b"Calibration complete!" in board.port.read()


# ---- motions ----


def test_move_abs_takes_the_time_that_its_ramps_take(on: Board) -> None:
    from_deg = on.now.r
    answer = on.do("move_abs", position_deg=from_deg + 360.0, velocity_rpm=60.0, acceleration_rpm_per_s=600.0)
    # 0.1 s up, 0.1 s down, 36 degrees together; 324 at 360 degrees a second.
    assert abs(answer["ends_after_ns"] - 1_100_000_000) <= 2
    assert answer["set_point"] == from_deg + 360.0
    on.run(100)
    assert abs(on.now.r - (from_deg + 18.0)) < 0.06  # of the latest control step, 154 us ago at most
    on.run(450)
    assert abs(on.now.r - (from_deg + 180.0)) < 0.06
    on.run(549.9)
    assert on.now.following == 1
    on.run(0.3)
    assert (on.now.following, abs(on.now.r - from_deg - 360.0) < 1e-4) == (0, True)
    assert abs(on.run(300).position_deg - from_deg - 360.0) < 0.1


def test_a_move_while_it_moves_goes_on_from_where_the_path_is(on: Board) -> None:
    on.do("position", position_deg=0.0)
    on.run(300)
    on.do("move_abs", position_deg=360.0)
    state = on.run(300)
    on.do("move_abs", position_deg=0.0)
    points = [state.r] + [on.run(1).r for _ in range(1500)]
    rates = [(later - earlier) * 1000 for earlier, later in pairwise(points)]
    assert max(map(abs, rates)) < 60 * RPM * 1.2
    assert max(points) > state.r + 17.0  # it runs out with the ramp before it comes back
    assert on.now.r == 0.0


def test_two_relative_moves_add_up(on: Board) -> None:
    on.do("position", position_deg=10.0)
    on.run(300)
    on.do("move_rel", angle_deg=90.0)
    on.run(50)
    assert on.do("move_rel", angle_deg=-30.0)["set_point"] == 70.0
    on.run(3000)
    assert on.now.r == 70.0
    assert abs(on.now.position_deg - 70.0) < 0.1


def test_a_move_out_of_a_speed_begins_with_that_speed(on: Board) -> None:
    on.do("velocity", velocity_rpm=60.0)
    state = on.run(1000)
    on.do("move_rel", angle_deg=360.0)
    assert on.now.mode == ord("x")
    rate = (on.run(20).r - state.position_deg) / 0.02
    assert abs(rate - 60 * RPM) < 0.2 * 60 * RPM
    on.run(3000)
    assert abs(on.now.r - state.position_deg - 360.0) < 1.0


def test_a_relative_move_out_of_a_stop_of_a_speed_begins_where_the_shaft_is(on: Board) -> None:
    on.do("velocity", velocity_rpm=60.0)
    on.run(2000)
    on.do("stop", acceleration_rpm_per_s=100.0)
    state = on.run(100)
    assert state.following == 1
    answer = on.do("move_rel", angle_deg=90.0)
    assert abs(answer["set_point"] - state.position_deg - 90.0) < 1.0


def test_stop_with_grace_in_each_mode(on: Board) -> None:
    on.do("position", position_deg=0.0)
    on.run(300)
    on.do("move_abs", position_deg=3600.0)
    before = on.run(1000)
    answer = on.do("stop", acceleration_rpm_per_s=300.0)
    assert abs(answer["ends_after_ns"] - 200_000_000) <= 1
    assert abs(answer["set_point"] - before.r - 36.0) < 0.1
    assert abs(on.run(500).r - answer["set_point"]) < 1e-3
    on.do("velocity", velocity_rpm=-60.0)
    on.run(1000)
    assert on.do("stop", acceleration_rpm_per_s=300.0)["ends_after_ns"] == 200_000_000
    assert abs(on.run(100).r + 30.0) < 0.1
    state = on.run(400)
    assert (state.r, state.mode, state.loop_on) == (0.0, ord("v"), 1)
    on.do("torque", effort_count=20.0)
    on.run(10)
    on.do("stop")
    assert on.now.r == 0.0


def test_stop_at_once_in_each_mode(on: Board) -> None:
    on.do("move_abs", position_deg=3600.0)
    on.run(1000)
    on.do("stop", how="prejudice")
    assert (on.now.following, abs(on.now.r - on.now.position_deg) < 0.1) == (0, True)
    for verb, name in (("velocity", "velocity_rpm"), ("torque", "effort_count")):
        on.do(verb, **{name: 20.0})
        on.run(100)
        on.do("stop", how="prejudice")
        assert on.now.r == 0.0


def test_stop_with_the_loop_off_does_nothing(board: Board) -> None:
    r = board.now.r
    assert board.do("stop") == {"effective_at_ns": board.bench.now_ns}
    assert (board.now.r, board.now.loop_on) == (r, 0)


@pytest.mark.parametrize(("typed", "r"), [(b"r12.5\n", 12.5), (b"n", None), (b"v", None)])
def test_what_is_typed_during_a_path_ends_it(on: Board, typed: bytes, r: float | None) -> None:
    on.do("move_abs", position_deg=3600.0)
    on.run(500)
    on.typed(typed)
    state = on.now
    assert state.following == 0
    assert on.run(500).r == state.r
    assert r is None or state.r == r


def test_a_path_that_would_take_centuries_is_refused_and_the_board_lives(on: Board) -> None:
    far = b"r1999999999\n"
    on.typed(b"n" + far + b"x", 100)
    on.do("enable")
    on.typed(far, 10)
    code, why = on.refusal("move_abs", position_deg=0.0, velocity_rpm=0.001)
    assert (code, why) == (
        "not_now",
        "no path leads there from the set-point 2e+09; set another one first",
    )
    on.typed(b"v" + far, 10)
    assert on.refusal("stop", acceleration_rpm_per_s=0.01)[0] == "not_now"
    on.do("stop", how="prejudice")
    assert on.now.r == 0.0


def test_pulses_at_the_step_input(on: Board) -> None:
    on.do("position", position_deg=0.0)
    on.run(300)
    answer = on.do("pulses", count=160, rate_Hz=1000.0)
    assert answer["ends_after_ns"] == 160_001_000
    on.run(80)
    assert 0 < on.now.r < 9.0
    on.run(100)
    assert abs(on.now.r - 160 * 0.05625) < 1e-4
    on.do("pulses", count=320, rate_Hz=100_000.0, direction="down")
    on.run(10)
    assert abs(on.now.r + 160 * 0.05625) < 1e-4
    assert on.refusal("pulses", count=1.5) == ("bad_parameter", "count: write a whole number")


@pytest.mark.parametrize("how", ["grace", "prejudice"])
def test_stop_ends_pulses_too(on: Board, how: str) -> None:
    on.do("pulses", count=1000, rate_Hz=1000.0)
    on.run(300)
    on.do("stop", how=how)
    r = on.run(1).r
    assert on.run(1500).r == r
    on.do("disable")
    on.do("pulses", count=1000, rate_Hz=1000.0)
    on.run(300)
    on.do("stop", how=how)
    r = on.now.r
    assert on.run(1000).r == r
