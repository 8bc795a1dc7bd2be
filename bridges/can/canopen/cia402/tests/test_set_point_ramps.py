"""Ramps from any motion: without jumps, within their rules, and to where they should lead."""

from itertools import pairwise

from hypothesis import example, given
from hypothesis import strategies as st

from bridges.can.canopen.cia402.movers import (
    ENDLESS_NS,
    MotionRules,
    SetPointNow,
    through,
    to_a_stop,
    to_speed,
    to_target,
)
from hil.vocab.path import Path

angles = st.floats(-1e4, 1e4)
rates = st.floats(-3000, 3000)
speeds, ramps = st.floats(1, 3000), st.floats(100, 1e5)
jerks = st.none() | st.floats(1e4, 1e7)


def check(path: Path, now: SetPointNow, rules: MotionRules) -> None:
    """Check that nothing jumps, and that the rules are kept but for what the start has already."""
    assert abs(path[0].r - now.deg) <= 1e-6
    fastest = max(rules.speed, abs(now.rate)) * (1 + 1e-6) + 1e-4
    steepest = max(rules.acceleration, rules.deceleration, abs(now.acceleration)) * (1 + 1e-6) + 0.02
    for piece, after in pairwise(path):
        r, rate = piece.after(piece.duration_ns)
        assert abs(r - after.r) <= 1e-4 * (1 + abs(r) * 1e-6)
        if after.duration_ns:
            assert abs(rate - after.per_s) <= 1e-3
        for part in range(5):
            into_ns = piece.duration_ns * part // 4
            _, rate = piece.after(into_ns)
            assert abs(rate) <= fastest
            assert abs(piece.per_s2 + into_ns * 1e-9 * piece.per_s3) <= steepest


@given(angles, rates, angles, speeds, ramps, ramps, jerks)
@example(0.0, 0.0, 0.0, 1.0, 100.0, 100.0, None)
@example(0.0, 360.0, 1.0, 360.0, 3600.0, 3600.0, None)
@example(0.0, 360.0, 18.0, 360.0, 3600.0, 3600.0, None)
def test_a_target_is_where_it_ends(
    deg: float, rate: float, target: float, speed: float, up: float, down: float, jerk: float | None
) -> None:
    now, rules = SetPointNow(deg, rate), MotionRules(speed, up, down, jerk)
    path = to_target(now, target, rules)
    check(path, now, rules)
    assert path[-1].r == target
    assert path[-1].duration_ns == 0


@given(angles, rates, rates, ramps, ramps, jerks)
def test_a_speed_is_kept(
    deg: float, rate: float, wanted: float, up: float, down: float, jerk: float | None
) -> None:
    now, rules = SetPointNow(deg, rate), MotionRules(max(abs(wanted), 1.0), up, down, jerk)
    path = to_speed(now, wanted, rules)
    check(path, now, rules)
    assert path[-1].per_s == wanted
    assert path[-1].duration_ns == (ENDLESS_NS if wanted else 0)


@given(angles, rates, angles, speeds, ramps, ramps)
def test_a_target_is_passed_in_motion(
    deg: float, rate: float, target: float, speed: float, up: float, down: float
) -> None:
    now, rules = SetPointNow(deg, rate), MotionRules(speed, up, down)
    found = through(now, target, rules)
    if found is None:
        assert rate * (target - deg) <= 0
        return
    path, end_rate = found
    check(path, now, rules)
    assert path[-1].r == target
    r, last = path[-2].after(path[-2].duration_ns) if len(path) > 1 else (target, end_rate)
    assert abs(r - target) <= 1e-3
    assert abs(last - end_rate) <= 1e-2 + abs(end_rate) * 1e-3


@given(angles, rates, ramps)
def test_a_stop_ends_at_rest(deg: float, rate: float, down: float) -> None:
    path = to_a_stop(SetPointNow(deg, rate), down)
    assert abs(path[-1].r - (deg + rate * abs(rate) / 2 / down)) <= 1e-6 * (1 + abs(path[-1].r))


def test_up_and_down_differ() -> None:
    path = to_target(SetPointNow(0.0), 90.0, MotionRules(360.0, 3600.0, 1800.0))
    assert [piece.duration_ns for piece in path] == [100_000_000, 100_000_000, 200_000_000, 0]
