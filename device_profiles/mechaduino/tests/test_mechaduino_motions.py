"""Motions of a Mechaduino that verbs begin and end, at exact simulated times."""

from itertools import pairwise

import pytest
from mechaduino_board import RPM, Board


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
    assert on.refusal("pulses", count=1.5) == (
        "bad_parameter",
        "count: 1.5 is not whole; write a whole number, 1 to 1000000 pulse",
    )


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
