"""Paths of a set-point keep their limits, and lead where they should."""

import math
from itertools import pairwise

from hypothesis import example, given
from hypothesis import strategies as st

from hil.firmware.set_point_paths import at, length_ns, to_rest, trapezoid
from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_S

positions = st.floats(-1e4, 1e4)
rates = st.floats(-2e3, 2e3)
speeds = st.floats(0.01, 18_000)
ramps = st.floats(1.0, 6e6)


def tolerance(*numbers: float) -> float:
    """Tolerance for rounding: of double precision along the way, and of whole nanoseconds at such speeds."""
    return 1e-9 * (1 + max(map(abs, numbers)))


def check_joined(path: tuple[PathPiece, ...], per_s2: float) -> None:
    """Check that each piece begins where the one before ends, in place and in rate."""
    furthest = max(abs(piece.r) for piece in path)
    for piece, after in pairwise(path):
        assert piece.duration_ns > 0
        r, rate = piece.after(piece.duration_ns)
        slack = 1e-9 * (abs(rate) + abs(piece.per_s) + 1) + 1e-9 * per_s2 * piece.duration_ns / NS_PER_S
        assert abs(r - after.r) <= tolerance(r, furthest) + slack
        assert abs(rate - after.per_s) <= 2e-9 * per_s2 + tolerance(rate, piece.per_s)
    assert path[-1].duration_ns == 0


@given(positions, rates, positions, speeds, ramps)
@example(0.0, 0.0, 0.0, 360.0, 3600.0)  # it is there
@example(5.0, 360.0, 5.0, 360.0, 3600.0)  # it is there, and passes
@example(0.0, 360.0, 18.0, 360.0, 3600.0)  # it stops just there
@example(0.0, 360.0, 10.0, 360.0, 3600.0)  # it cannot stop before
@example(0.0, 720.0, 1000.0, 360.0, 3600.0)  # it is too fast
@example(0.0, -360.0, 1000.0, 360.0, 3600.0)  # the wrong way
@example(0.0, 0.0, 1e-9, 360.0, 3600.0)  # less than a nanosecond's
def test_a_trapezoid_keeps_its_limits_and_ends_at_its_target(
    r: float, rate: float, target: float, per_s: float, per_s2: float
) -> None:
    path = trapezoid(r, rate, target, per_s, per_s2)
    check_joined(path, per_s2)
    assert path[-1] == PathPiece(0, target)
    assert at(path, length_ns(path)) == (target, 0.0)
    assert at(path, length_ns(path) + 10**15) == (target, 0.0)
    if len(path) > 1:
        assert (path[0].r, path[0].per_s) == (r, rate)
    most = max(per_s, abs(rate))
    for piece in path:
        assert abs(piece.per_s2) in (0.0, per_s2)
        assert piece.per_s3 == 0.0
        for into_ns in (0, piece.duration_ns // 2, piece.duration_ns):
            assert abs(piece.after(into_ns)[1]) <= most * (1 + 1e-9) + 2e-9 * per_s2
    # Once it is not faster than allowed, it never is again.
    fast = [abs(piece.after(piece.duration_ns)[1]) > per_s * (1 + 1e-9) + 2e-9 * per_s2 for piece in path]
    assert not any(fast) or abs(rate) > per_s


@given(positions, positions, speeds, ramps)
def test_from_rest_it_never_turns_and_takes_the_shortest_time(
    r: float, target: float, per_s: float, per_s2: float
) -> None:
    path = trapezoid(r, 0.0, target, per_s, per_s2)
    distance = abs(target - r)
    peak = min(per_s, math.sqrt(per_s2 * distance))
    seconds = distance / peak + peak / per_s2 if peak else 0.0
    assert abs(length_ns(path) - seconds * NS_PER_S) <= 3 + 1e-9 * seconds * NS_PER_S
    points = [at(path, length_ns(path) * k // 50)[0] for k in range(51)]
    sign = 1 if target >= r else -1
    slack = tolerance(r, target) + 3e-9 * peak
    assert all((later - earlier) * sign >= -slack for earlier, later in pairwise(points))


def test_what_cannot_stop_before_the_target_comes_back() -> None:
    path = trapezoid(0.0, 360.0, 10.0, 360.0, 3600.0)
    furthest = max(at(path, length_ns(path) * k // 1000)[0] for k in range(1001))
    assert abs(furthest - 18.0) < 0.01  # 360 ** 2 / 2 / 3600
    # 0.1 s to rest, then 8 degrees back and no cruise.
    assert abs(length_ns(path) - (0.1 + 2 * math.sqrt(8 / 3600)) * NS_PER_S) <= 3


def test_a_path_of_known_times() -> None:
    path = trapezoid(0.0, 0.0, 360.0, 360.0, 3600.0)
    assert [piece.duration_ns for piece in path] == [100_000_000, 900_000_000, 100_000_000, 0]
    assert at(path, 100_000_000) == (18.0, 360.0)
    assert at(path, 50_000_000) == (4.5, 180.0)


def test_where_it_is_already_there_is_no_way() -> None:
    assert trapezoid(7.25, 0.0, 7.25, 60.0, 600.0) == (PathPiece(0, 7.25),)


@given(positions, rates, ramps)
def test_to_rest_ends_at_rest_in_the_least_way(r: float, rate: float, per_s2: float) -> None:
    path = to_rest(r, rate, per_s2)
    check_joined(path, per_s2)
    end = path[-1]
    assert abs(end.r - (r + rate * abs(rate) / (2 * per_s2))) <= tolerance(r, end.r)
    assert abs(length_ns(path) - abs(rate) / per_s2 * NS_PER_S) <= 1
    assert at(path, length_ns(path)) == (end.r, 0.0)


def test_a_piece_with_jerk() -> None:
    piece = PathPiece(10**9, 1.0, 2.0, 6.0, 12.0)
    assert piece.after(10**9) == (1.0 + 2.0 + 3.0 + 2.0, 2.0 + 6.0 + 6.0)
