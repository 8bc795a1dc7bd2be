"""Plans for several axes: limits, ends, lines, splines, stops, and what cannot be planned."""

import hashlib
import math
import re
import struct
from dataclasses import astuple, replace
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hil.core import _trajectory
from hil.core.trajectory import (
    MAX_AXES,
    AxisLimits,
    PlanError,
    PlanProblem,
    PointState,
    Trajectory,
    plan_joint,
    plan_line,
    plan_spline,
    plan_spline_within,
    plan_velocity,
)

LIMITS = AxisLimits(100, 1000, 20_000)
KINDS = st.sampled_from(["trapezoid", "s_curve"])
SLACK = 1 + 1e-9


def powers(low, high):
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


ANY_LIMITS = st.builds(AxisLimits, powers(0, 4), powers(0, 5), powers(1, 6))
FRACTIONS = st.floats(-1, 1).map(lambda x: round(x, 9))
POSITIONS = st.floats(-720, 720, allow_subnormal=False)


@st.composite
def moves(draw, at_rest=False):
    """(start, target, limits) of an axis."""
    limits, position, target = draw(ANY_LIMITS), draw(POSITIONS), draw(POSITIONS)
    if at_rest or draw(st.booleans()):
        return PointState(position), target, limits
    velocity, acceleration = draw(FRACTIONS), draw(FRACTIONS)
    start = PointState(position, velocity * limits.velocity_max, acceleration * limits.acceleration_max)
    later = start.acceleration_deg_per_s2 * abs(start.acceleration_deg_per_s2) / (2 * limits.jerk_max)
    assume(abs(start.velocity_deg_per_s + later) <= limits.velocity_max)
    return start, target, limits


def columns(rows):
    return tuple(map(list, zip(*rows, strict=True)))


def sampled(plan: Trajectory, parts: int = 40):
    return [plan.at(plan.duration_ns * part // parts) for part in range(parts + 1)]


def assert_within(plan, limits):
    assert plan.violation(limits) is None
    for states in sampled(plan):
        for state, limit in zip(states, limits, strict=True):
            assert abs(state.velocity_deg_per_s) <= limit.velocity_max * SLACK
            assert abs(state.acceleration_deg_per_s2) <= limit.acceleration_max * SLACK


def assert_rests_at(plan, targets):
    end = tuple(PointState(target) for target in targets)
    assert plan.at(plan.duration_ns) == plan.at(plan.duration_ns + 10**9) == end
    # what the segments lead to, which the exact end only rounds
    for axis, target in enumerate(targets):
        if segments := plan.segments(axis):
            last = segments[-1]
            d = last.length_s
            reached = last.position_deg + d * (
                last.velocity_deg_per_s
                + d * (last.acceleration_deg_per_s2 / 2 + d * last.jerk_deg_per_s3 / 6)
            )
            biggest = max(abs(segment.position_deg) for segment in segments)
            assert reached == pytest.approx(target, rel=1e-9, abs=1e-9 * (biggest + 1))


@given(st.lists(moves(), min_size=1, max_size=6), st.sampled_from([None, 1.0, 1.37, 5.0]))
def test_limits_are_kept_and_the_end_is_exact(rows, stretch):
    starts, targets, limits = columns(rows)
    plan = plan_joint(starts, targets, limits)
    if stretch is not None:
        wanted_ns = math.ceil(plan.duration_ns * stretch)
        plan = plan_joint(starts, targets, limits, duration_ns=wanted_ns)
        assert plan.duration_ns == wanted_ns
    if plan.duration_ns:
        assert plan.at(0) == tuple(starts)
    assert_within(plan, limits)
    assert_rests_at(plan, targets)


@given(st.lists(moves(at_rest=True), min_size=1, max_size=6), KINDS)
def test_a_plan_from_rest_has_seven_segments_at_most(rows, kind):
    starts, targets, limits = columns(rows)
    plan = plan_joint(starts, targets, limits, kind)
    assert all(len(plan.segments(axis)) <= (7 if kind == "s_curve" else 3) for axis in range(plan.axes))


@given(st.lists(moves(), min_size=1, max_size=4), KINDS)
def test_a_mirrored_move_is_the_mirrored_plan(rows, kind):
    starts, targets, limits = columns(rows)
    plan = plan_joint(starts, targets, limits, kind)
    mirrored = plan_joint(
        [PointState(*(-x for x in astuple(s))) for s in starts], [-t for t in targets], limits, kind
    )
    assert mirrored.duration_ns == plan.duration_ns
    for there, here in zip(sampled(mirrored), sampled(plan), strict=True):
        assert there == tuple(PointState(*(-x for x in astuple(state))) for state in here)


@given(st.lists(moves(), min_size=1, max_size=4), st.integers(1, 40), st.integers(1, 10**8))
def test_positions_are_the_same_in_any_chunks(rows, chunk, step_ns):
    plan = plan_joint(*columns(rows))
    whole = plan.positions_deg(0, step_ns, 120)
    pieces = [
        x
        for at in range(0, 120, chunk)
        for x in plan.positions_deg(at * step_ns, step_ns, min(chunk, 120 - at))
    ]
    one_by_one = [state.position_deg for k in range(120) for state in plan.at(k * step_ns)]
    assert list(whole) == pieces == one_by_one


@given(moves(at_rest=True), st.floats(0, 0.45))
def test_the_soonest_way_is_soonest_from_each_of_its_states(move, part):
    """Bellman's principle: planned again on the way, before it brakes, the rest takes what was left of it."""
    start, target, limits = move
    assume(abs(target - start.position_deg) > 1e-6)  # else where it is on the way is mostly rounding
    plan = plan_joint([start], [target], [limits])
    at_ns = int(plan.duration_ns * part)
    again = plan_joint(plan.at(at_ns), [target], [limits])
    assert again.duration_ns == pytest.approx(plan.duration_ns - at_ns, rel=1e-6, abs=2)


@given(moves(at_rest=True), KINDS, st.floats(0.5, 0.999))
def test_less_time_than_the_least_is_refused_and_the_least_is_not(move, kind, part):
    start, target, limits = move
    least_ns = plan_joint([start], [target], [limits], kind).duration_ns
    assume(least_ns > 10)
    with pytest.raises(PlanError, match=f"at least {least_ns} ns") as refused:
        plan_joint([start], [target], [limits], kind, duration_ns=int(least_ns * part))
    assert (refused.value.problem, refused.value.axis) == (PlanProblem.TOO_SHORT, 0)
    assert refused.value.least_ns == least_ns
    assert plan_joint([start], [target], [limits], kind, duration_ns=least_ns).duration_ns == least_ns


@given(st.lists(moves(at_rest=True), min_size=1, max_size=6), KINDS, st.floats(0, 1))
def test_a_line_and_its_stop_are_straight(rows, kind, part):
    starts, targets, limits = columns(rows)
    froms = [start.position_deg for start in starts]
    plan = plan_line(froms, targets, limits, kind)
    stop = plan.stop(int(plan.duration_ns * part), limits)
    length = max(abs(b - a) for a, b in zip(froms, targets, strict=True))
    assert_rests_at(plan, targets)
    for line in (plan, stop):
        assert line.violation(limits) is None
        for states in sampled(line, 10):
            done = [(s.position_deg - a, b - a) for s, a, b in zip(states, froms, targets, strict=True)]
            farthest = max(done, key=lambda pair: abs(pair[1]))
            for went, wants in done:
                assert went * farthest[1] == pytest.approx(
                    farthest[0] * wants, abs=1e-12 * 720 * (length + 1e-3)
                )


@given(st.lists(moves(at_rest=True), min_size=2, max_size=5), KINDS)
def test_a_line_is_as_soon_as_its_slowest_axis_or_later(rows, kind):
    starts, targets, limits = columns(rows)
    line = plan_line([start.position_deg for start in starts], targets, limits, kind)
    assert line.duration_ns >= plan_joint(starts, targets, limits, kind).duration_ns - 1


@pytest.mark.parametrize("kind", ["trapezoid", "s_curve"])
def test_a_line_uses_its_limits_up(kind):
    half = AxisLimits(50, 500, 10_000)
    one = plan_joint([PointState(0)], [10], [LIMITS], kind)
    assert plan_line([0, 0, 3], [10, -5, 3], [LIMITS, half, half], kind).duration_ns == one.duration_ns
    assert plan_line([0, 0], [10, 5.1], [LIMITS, half], kind).duration_ns > one.duration_ns


@given(st.lists(moves(), min_size=1, max_size=4), st.floats(0, 1))
def test_a_stop_starts_smoothly_and_keeps_the_limits(rows, part):
    starts, targets, limits = columns(rows)
    plan = plan_joint(starts, targets, limits)
    at_ns = int(plan.duration_ns * part)
    stop = plan.stop(at_ns, limits)
    if stop.duration_ns:
        for now, then in zip(stop.at(0), plan.at(at_ns), strict=True):
            assert astuple(now) == pytest.approx(astuple(then), rel=1e-9, abs=1e-9)
    assert_within(stop, limits)
    assert all(astuple(state)[1:] == (0, 0) for state in stop.at(stop.duration_ns))
    assert stop.duration_ns <= max(plan_velocity(plan.at(at_ns), [0] * len(rows), limits).duration_ns, 0)


def test_a_velocity_is_reached_and_kept():
    plan = plan_velocity([PointState(0), PointState(5, 40)], [100, -100], [LIMITS, LIMITS])
    assert plan.duration_ns == 190_000_000  # 140 deg/s: 0.14 s at 1000 deg/s2, and 0.05 s for the jerk
    first, second = plan.at(plan.duration_ns)
    assert (first.velocity_deg_per_s, second.velocity_deg_per_s) == (100, -100)
    later = plan.at(plan.duration_ns + 10**9)
    assert later[1].position_deg == pytest.approx(second.position_deg - 100)


@st.composite
def splines(draw):
    axes = draw(st.integers(1, 4))
    points = draw(
        st.lists(st.tuples(*[st.floats(-180, 180, allow_subnormal=False)] * axes), min_size=2, max_size=12)
    )
    gaps = draw(st.lists(st.integers(10**6, 10**10), min_size=len(points) - 1, max_size=len(points) - 1))
    start = draw(st.integers(-(10**12), 10**12))
    return points, [start + sum(gaps[:k]) for k in range(len(points))]


@given(splines())
def test_a_spline_passes_its_points_from_rest_to_rest(spline):
    points, times_ns = spline
    plan = plan_spline(points, times_ns)
    assert plan.at(0) == tuple(PointState(x) for x in points[0])
    assert_rests_at(plan, points[-1])
    assert plan.duration_ns == times_ns[-1] - times_ns[0]
    for point, at_ns in zip(points, times_ns, strict=True):
        states = plan.at(at_ns - times_ns[0])
        biggest = max(abs(s.position_deg) for axis in range(plan.axes) for s in plan.segments(axis))
        assert [s.position_deg for s in states] == pytest.approx(point, abs=1e-9 * (biggest + 1))
    for axis in range(plan.axes):
        segments = plan.segments(axis)
        for here, there in pairwise(segments):
            d = here.length_s
            speed = here.velocity_deg_per_s + d * (
                here.acceleration_deg_per_s2 + d * here.jerk_deg_per_s3 / 2
            )
            fastest = max(abs(s.velocity_deg_per_s) for s in segments)
            assert speed == pytest.approx(there.velocity_deg_per_s, abs=1e-9 * (fastest + 1))


@given(splines(), st.data())
def test_a_spline_is_slowed_until_it_keeps_the_limits(spline, data):
    points, times_ns = spline
    limits = [data.draw(ANY_LIMITS) for _ in points[0]]
    plan = plan_spline(points, times_ns)
    fitted = plan.fitted(limits)
    assert_within(fitted, limits)
    if plan.violation(limits) is None:
        assert fitted.duration_ns - plan.duration_ns in (0, 1)
    else:
        assert fitted.duration_ns > plan.duration_ns
        tighter = [AxisLimits(*(0.99 * limit for limit in astuple(axis))) for axis in limits]
        assert fitted.violation(tighter) is not None


@given(splines(), st.data())
def test_times_from_the_limits_are_as_short_as_these_let_them_be(spline, data):
    points = [point for k, point in enumerate(spline[0]) if k == 0 or point != spline[0][k - 1]]
    assume(len(points) > 1)
    assume(all(math.dist(a, b) > 1e-3 for a, b in pairwise(points)))
    limits = [data.draw(ANY_LIMITS) for _ in points[0]]
    plan = plan_spline_within(points, limits)
    assert_within(plan, limits)
    assert plan.violation([AxisLimits(*(0.99 * x for x in astuple(axis))) for axis in limits]) is not None


def test_the_first_violation_is_told():
    # 1 deg in 3 s: accelerations 0, 1, -1, 0 deg/s2 at the whole seconds
    plan = plan_spline([(0.0, 0.0), (1.0, 3.0)], [0, 3_000_000_000])
    wide = AxisLimits(10, 10, 10)
    found = plan.violation([replace(wide, velocity_max=0.7), wide])
    assert found is not None
    assert (found.axis, found.quantity, found.at_ns, found.limit) == (0, "velocity", 1_500_000_000, 0.7)
    assert found.value == pytest.approx(0.75)
    found = plan.violation([replace(wide, velocity_max=0.7), replace(wide, acceleration_max=2)])
    assert found is not None
    assert (found.axis, found.quantity, found.at_ns) == (1, "acceleration", 1_000_000_000)
    assert found.value == pytest.approx(3)
    assert plan.violation([wide, wide]) is None


FAR = PointState(0), PointState(0)
SPLINE = plan_spline([(0,), (1,)], [0, 10**9])


@pytest.mark.parametrize(
    ("problem", "axis", "plan"),
    [
        ("NOT_FINITE", 1, lambda: plan_joint(FAR, [1, math.nan], [LIMITS] * 2)),
        ("NOT_FINITE", 0, lambda: plan_joint([PointState(0, math.inf)], [1], [LIMITS])),
        ("NOT_FINITE", 0, lambda: plan_line([0], [-math.inf], [LIMITS])),
        ("NOT_FINITE", 0, lambda: plan_velocity([PointState(0)], [math.nan], [LIMITS])),
        ("NOT_FINITE", 1, lambda: plan_spline([(0, 0), (1, math.nan)], [0, 1])),
        ("NOT_FINITE", 0, lambda: plan_joint([PointState(0)], [1], [replace(LIMITS, jerk_max=math.inf)])),
        ("LIMIT_NOT_POSITIVE", 1, lambda: plan_line([0, 0], [1, 1], [LIMITS, AxisLimits(1, 0, 1)])),
        ("LIMIT_NOT_POSITIVE", 0, lambda: SPLINE.violation([AxisLimits(-1, 1, 1)])),
        ("LIMIT_NOT_POSITIVE", 0, lambda: SPLINE.fitted([AxisLimits(1, 1, 0)])),
        ("LIMIT_NOT_POSITIVE", 0, lambda: SPLINE.stop(0, [AxisLimits(1, 1, 0)])),
        ("LIMIT_NOT_POSITIVE", 0, lambda: plan_spline_within([(0,), (1,)], [AxisLimits(1, 1, 0)])),
        ("OUT_OF_RANGE", None, lambda: SPLINE.fitted([AxisLimits(1e-300, 1, 1)])),
        ("NO_AXES", None, lambda: plan_joint([], [], [])),
        ("TOO_MANY_AXES", None, lambda: plan_line([0] * 65, [1] * 65, [LIMITS] * 65)),
        ("TOO_MANY_AXES", None, lambda: plan_spline([[0] * 65, [1] * 65], [0, 1])),
        ("START_BEYOND_LIMITS", 0, lambda: plan_joint([PointState(0, 101)], [1], [LIMITS])),
        ("START_BEYOND_LIMITS", 0, lambda: plan_joint([PointState(0, 90, 900)], [1], [LIMITS])),
        ("TARGET_BEYOND_LIMIT", 0, lambda: plan_velocity([PointState(0)], [101], [LIMITS])),
        ("TOO_SHORT", 1, lambda: plan_joint(FAR, [1, 2], [LIMITS] * 2, duration_ns=0)),
        ("TOO_SHORT", 0, lambda: plan_line([0], [1], [LIMITS], duration_ns=-(10**30))),
        ("TOO_FEW_POINTS", 0, lambda: plan_spline([(0,)], [0])),
        ("TOO_FEW_POINTS", None, lambda: plan_spline([], [])),
        ("POINTS_OUT_OF_ORDER", 0, lambda: plan_spline([(0,), (1,), (2,)], [0, 5, 5])),
        ("POINTS_OUT_OF_ORDER", 0, lambda: plan_spline_within([(0,), (1,), (1,)], [LIMITS])),
        ("OUT_OF_RANGE", None, lambda: plan_joint([PointState(0)], [1], [LIMITS], duration_ns=10**30)),
        ("OUT_OF_RANGE", 0, lambda: plan_joint([PointState(-1e308)], [1e308], [LIMITS])),
    ],
)
def test_what_cannot_be_planned_is_named(problem, axis, plan):
    with pytest.raises(PlanError) as refused:
        plan()
    assert (refused.value.problem, refused.value.axis) == (PlanProblem[problem], axis)


def test_as_many_axes_as_there_may_be():
    plan = plan_line([0] * MAX_AXES, range(MAX_AXES), [LIMITS] * MAX_AXES)
    assert [state.position_deg for state in plan.at(plan.duration_ns)] == list(range(MAX_AXES))


def test_lengths_that_differ_are_refused():
    with pytest.raises(ValueError, match="1 values for 2"):
        plan_joint([PointState(0)], [1, 2], [LIMITS] * 2)
    with pytest.raises(ValueError, match="1 values for 2"):
        plan_line([0, 0], [1, 2], [LIMITS] * 2).violation([LIMITS])


def test_the_bits_are_the_same_on_every_machine():
    """Plans use + - * / and sqrt only, nothing contracted: another compiler, level or processor changes no
    bit."""
    digest = hashlib.sha256()
    for k in range(1, 60):
        limits = [AxisLimits(10 + 7 * k, 100 + 31 * k * axis, 1000 + 997 * k / axis) for axis in (1, 2, 3)]
        starts = [
            PointState(k / 3, -3.0 - k / 9, 20.0 + k / 7),
            PointState(-k),
            PointState(k / 7, 9.0, -9.0),
        ]
        points = [(k / 3 + x, -k + x * x, x / 7) for x in range(k % 5 + 2)]
        for plan in (
            plan_joint(starts, [k * k / 7, -k / 11, 90 - k], limits),
            plan_joint(starts, [k * k / 7, -k / 11, 90 - k], limits, "trapezoid", 60 * 10**9),
            plan_line([0, k / 3, 7], [k / 11, -k * k, 7 / k], limits).stop(10**8, limits),
            plan_spline_within(points, limits),
        ):
            positions = plan.positions_deg(0, plan.duration_ns // 97 + 1, 100)
            digest.update(struct.pack(f"<{len(positions)}d", *positions))
    assert digest.hexdigest() == "75bb0584ab80dadde179fb8007e5ddeab3259528d57c8a4ff0116dc9c9d96a8c"


def test_problems_are_those_of_the_header():
    header = (Path(_trajectory.__file__).parent / "native/motion/course.h").read_text()
    enum = re.search(r"typedef enum traj_error \{(.*?)\}", header, re.DOTALL)
    assert enum is not None
    names = re.findall(r"^\s*TRAJ_(\w+),", enum[1], re.MULTILINE)
    assert names == ["OK", *(problem.name for problem in PlanProblem)]
