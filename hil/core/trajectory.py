"""Trajectories over several axes: position, velocity and acceleration of each axis at any time.

Positions are in degrees, velocities in deg/s, accelerations in deg/s2, jerks in deg/s3, times in integer ns
from hil.vocab.late_dataclass import dataclass
machine. ``native/motion/trajectory.h`` has the plans, ``docs/decisions/0013`` the reasons.
"""

from array import array
from collections.abc import Sequence
from enum import IntEnum
from itertools import pairwise
from typing import Literal

from hil.core import _trajectory
from hil.vocab.late_dataclass import dataclass
from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_S

Kind = Literal["trapezoid", "s_curve"]
"""Trapezoids keep the limits of velocity and acceleration, S-curves that of jerk too."""

MAX_AXES = _trajectory.MAX_AXES
_MOST_NS = 2**63 - 1


class PlanProblem(IntEnum):
    """Names of ``traj_error`` of ``native/motion/course.h``, in its order."""

    NOT_FINITE = 1
    LIMIT_NOT_POSITIVE = 2
    NO_AXES = 3
    TOO_MANY_AXES = 4
    START_BEYOND_LIMITS = 5
    TARGET_BEYOND_LIMIT = 6
    TOO_SHORT = 7
    TOO_FEW_POINTS = 8
    POINTS_OUT_OF_ORDER = 9
    NO_ROOM = 10
    OUT_OF_RANGE = 11


_MEANINGS = {
    PlanProblem.NOT_FINITE: "a number is infinite or not a number",
    PlanProblem.LIMIT_NOT_POSITIVE: "a limit is not above 0",
    PlanProblem.NO_AXES: "there is no axis",
    PlanProblem.TOO_MANY_AXES: f"there are more than {MAX_AXES} axes",
    PlanProblem.START_BEYOND_LIMITS: "the start is beyond the limits, or cannot but exceed them",
    PlanProblem.TARGET_BEYOND_LIMIT: "the velocity is beyond the limit",
    PlanProblem.TOO_SHORT: "the duration is too short",
    PlanProblem.TOO_FEW_POINTS: "a spline needs two points",
    PlanProblem.POINTS_OUT_OF_ORDER: "each point needs a later time than the one before",
    PlanProblem.NO_ROOM: "there is no room for the segments",
    PlanProblem.OUT_OF_RANGE: "the numbers are too far apart: a result overflows, or takes over 100 years",
}


class PlanError(ValueError):
    """Error of a motion that cannot be planned: the problem, its axis (None: no single one), and the least
    duration if too short a one was asked for."""

    def __init__(self, problem: PlanProblem, axis: int | None = None, least_ns: int | None = None) -> None:
        least = "" if least_ns is None else f", at least {least_ns} ns"
        self.what = _MEANINGS[problem] + least
        super().__init__(f"{'' if axis is None else f'axis {axis}: '}{self.what}")
        self.problem = problem
        self.axis = axis
        self.least_ns = least_ns


@dataclass(frozen=True)
class AxisLimits:
    """Limits of an axis, in deg/s, deg/s2, deg/s3. A trapezoid has no use for the jerk."""

    velocity_max: float
    acceleration_max: float
    jerk_max: float


@dataclass(frozen=True)
class PointState:
    """State of an axis at one time. A trapezoid starts with any acceleration."""

    position_deg: float
    velocity_deg_per_s: float = 0.0
    acceleration_deg_per_s2: float = 0.0


@dataclass(frozen=True)
class Piece:
    """Piece of constant jerk: the state at its start, which is ``start_s`` after the trajectory's."""

    start_s: float
    length_s: float
    position_deg: float
    velocity_deg_per_s: float
    acceleration_deg_per_s2: float
    jerk_deg_per_s3: float


@dataclass(frozen=True)
class Violation:
    """Place where a limit is exceeded; the value has a sign."""

    axis: int
    quantity: Literal["velocity", "acceleration", "jerk"]
    at_ns: int
    value: float
    limit: float


_QUANTITIES: tuple[Literal["velocity", "acceleration", "jerk"], ...] = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class Trajectory:
    """Trajectory of all axes, as ``plan_joint`` and the others return it."""

    _course: _trajectory.Course
    kind: Kind

    @property
    def axes(self) -> int:
        return self._course.axes

    @property
    def duration_ns(self) -> int:
        """Duration, after which every axis is exactly at its end, at rest or at the velocity asked for."""
        return self._course.duration_ns

    def at(self, at_ns: int) -> tuple[PointState, ...]:
        """State of each axis at this time; before the start as at it."""
        return tuple(PointState(*self._course.at(axis, at_ns)) for axis in range(self.axes))

    def positions_deg(self, from_ns: int, step_ns: int, count: int) -> "array[float]":
        """Positions of all axes at ``count`` times, one time after the other: those of ``at``, but faster."""
        return self._course.positions(from_ns, step_ns, count)

    def segments(self, axis: int) -> tuple[Piece, ...]:
        """Segments of one axis; none if it stands. Raises IndexError for another axis."""
        return tuple(Piece(*values) for values in self._course.segments_of(axis))

    def pieces(self, axis: int) -> list[PathPiece]:
        """Pieces of one axis's path, their times in whole ns; none if it stands."""
        segments = self.segments(axis)
        times_ns = [*(round(each.start_s * NS_PER_S) for each in segments), self.duration_ns]
        return [
            PathPiece(
                to_ns - from_ns,
                each.position_deg,
                each.velocity_deg_per_s,
                each.acceleration_deg_per_s2,
                each.jerk_deg_per_s3,
            )
            for each, (from_ns, to_ns) in zip(segments, pairwise(times_ns), strict=True)
            if to_ns > from_ns
        ]

    def stop(self, at_ns: int, limits: Sequence[AxisLimits]) -> "Trajectory":
        """Plan a stop from the state at ``at_ns``, which is the new trajectory's time 0. Along the line of a
        line, otherwise each axis as soon as it can.

        Raises:
            PlanError: the limits are not finite and above 0.
        """
        _same_length(limits, self.axes)
        course = _trajectory.Course(self.axes)
        return _planned(course, course.stop(self._course, at_ns, limits, self.kind == "s_curve"), self.kind)

    def violation(self, limits: Sequence[AxisLimits]) -> Violation | None:
        """First end or turning point of a segment that exceeds a limit by more than a part in 1e9.

        Raises:
            PlanError: the limits are not finite and above 0.
        """
        self._check(limits)
        found = self._course.violation(limits, self.kind == "s_curve")
        if found is None:
            return None
        axis, quantity, at_ns, value, limit = found
        return Violation(axis, _QUANTITIES[quantity], at_ns, value, limit)

    def fitted(self, limits: Sequence[AxisLimits]) -> "Trajectory":
        """Slow the trajectory down on the same way, as little as the limits need; itself if it keeps them.

        Only for a trajectory that starts at rest: a start in motion would be slowed too.

        Raises:
            PlanError: the limits are not finite and above 0, or it would take over 100 years.
        """
        self._check(limits)
        return self._stretched(max(1.0, self._course.fit(limits, self.kind == "s_curve")))

    def _check(self, limits: Sequence[AxisLimits]) -> None:
        _same_length(limits, self.axes)
        _planned(self._course, self._course.check(limits, self.kind == "s_curve"), self.kind)

    def _stretched(self, factor: float) -> "Trajectory":
        if factor == 1:
            return self
        error, course = self._course.stretched(factor)
        return _planned(course, error, self.kind)


def plan_joint(
    starts: Sequence[PointState],
    targets_deg: Sequence[float],
    limits: Sequence[AxisLimits],
    kind: Kind = "s_curve",
    duration_ns: int | None = None,
) -> Trajectory:
    """Plan all axes from their starts to their targets at rest. They begin and end together: after
    ``duration_ns``, or as soon as the slowest can.

    Raises:
        PlanError: see ``PlanProblem``.
    """
    course = _course(starts, targets_deg, limits)
    error = course.joint(starts, targets_deg, limits, kind == "s_curve", *_duration(duration_ns))
    return _planned(course, error, kind)


def plan_line(
    starts_deg: Sequence[float],
    targets_deg: Sequence[float],
    limits: Sequence[AxisLimits],
    kind: Kind = "s_curve",
    duration_ns: int | None = None,
) -> Trajectory:
    """Plan a straight line from rest to rest, after ``duration_ns``, or as soon as every axis can.

    Raises:
        PlanError: see ``PlanProblem``.
    """
    course = _course(starts_deg, targets_deg, limits)
    error = course.line(starts_deg, targets_deg, limits, kind == "s_curve", *_duration(duration_ns))
    return _planned(course, error, kind)


def plan_velocity(
    starts: Sequence[PointState],
    velocities_deg_per_s: Sequence[float],
    limits: Sequence[AxisLimits],
    kind: Kind = "s_curve",
) -> Trajectory:
    """Plan each axis to a velocity as soon as it can, from any start, with which it then goes on.

    Raises:
        PlanError: see ``PlanProblem``.
    """
    course = _course(starts, velocities_deg_per_s, limits)
    return _planned(course, course.velocity(starts, velocities_deg_per_s, limits, kind == "s_curve"), kind)


def plan_spline(points_deg: Sequence[Sequence[float]], times_ns: Sequence[int]) -> Trajectory:
    """Plan a spline through points (one position for each axis) at times, of which the first is the start.

    Velocity and acceleration are continuous, and 0 at both ends. No limits: see ``violation`` and ``fitted``.

    Raises:
        PlanError: see ``PlanProblem``.
    """
    _same_length(times_ns, len(points_deg))
    axes = len(points_deg[0]) if points_deg else 1
    for point in points_deg:
        _same_length(point, axes)
    course = _trajectory.Course(axes, len(points_deg) + 1)
    return _planned(course, course.spline(times_ns, points_deg), "s_curve")


def plan_spline_within(points_deg: Sequence[Sequence[float]], limits: Sequence[AxisLimits]) -> Trajectory:
    """Plan the same with times from the limits. The intervals are in the proportion of moves from rest to
    rest, and as short as the limits let them be in it.

    Raises:
        PlanError: see ``PlanProblem``; POINTS_OUT_OF_ORDER if one point is the same as the one before it.
    """
    times_ns = [0]
    for here, there in pairwise(points_deg):
        chord = plan_joint([PointState(p) for p in here], there, limits)
        times_ns.append(times_ns[-1] + chord.duration_ns)
    plan = plan_spline(points_deg, times_ns[: len(points_deg)])
    return plan._stretched(plan._course.fit(limits, True))


def _course(starts: Sequence[object], ends: Sequence[object], limits: Sequence[object]) -> _trajectory.Course:
    _same_length(starts, len(ends))
    _same_length(limits, len(ends))
    return _trajectory.Course(len(ends))


def _duration(duration_ns: int | None) -> tuple[int, ...]:
    return () if duration_ns is None else (max(-1, min(duration_ns, _MOST_NS)),)


def _same_length(values: Sequence[object], count: int) -> None:
    if len(values) != count:
        raise ValueError(
            f"{len(values)} values for {count}: all sequences have one value for each axis or point"
        )


def _planned(course: _trajectory.Course, error: int, kind: Kind) -> Trajectory:
    if error:
        axis = course.fault_axis if course.fault_axis >= 0 else None
        problem = PlanProblem(error)
        raise PlanError(problem, axis, course.least_ns if problem is PlanProblem.TOO_SHORT else None)
    return Trajectory(course, kind)
