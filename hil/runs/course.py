"""Course of a phrase in the bench's time: as planned, slower, or paused, always along the planned paths.

A phrase's plan has a time of its own. While the pace is 1 it goes as the bench's does; at 0.5 half as fast,
at 0 it stands. From one pace to another it changes smoothly, within the axes' accelerations.
"""

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate, pairwise
from math import ceil, sqrt

from hil.runs.plan import Phrase
from hil.runs.run_document import AxisRules
from hil.vocab.path import DEG_PER_S, Path, PathPiece
from hil.vocab.time import NS_PER_S

BACK_NS = 50_000_000
"""Time before now at which a path begins that is given while the axes move, for a board that is behind."""
STEP_NS = 2_000_000
"""Duration of a piece while the pace changes: within it a speed is off by some ten-thousandths."""
LEAST_RAMP_NS = 20_000_000
STEEPEST = 1.5
"""Steepest slope of a change of pace, in shares of its mean: that of u * u * (3 - 2 * u)."""
PIECES = 500
"""Number of pieces of an axis that are given at a time; more would hold the bench's ports up."""
LEAST_S = 2.0
"""Least time for which pieces are given."""
AHEAD_NS = 1_000_000_000
"""Time before the end of the given pieces at which more are given."""


@dataclass(frozen=True)
class Leg:
    """Part of the course. From ``from_ns`` of the bench's time and ``at_ns`` of the plan's the pace changes
    from ``before`` to ``pace`` in ``ramp_ns``, then stays."""

    from_ns: int
    at_ns: float
    before: float
    pace: float
    ramp_ns: int = 0

    @property
    def steady_ns(self) -> int:
        return self.from_ns + self.ramp_ns

    @property
    def steady_at_ns(self) -> float:
        return self.at_ns + self.ramp_ns * (self.before + self.pace) / 2

    def plan_ns(self, now_ns: int) -> float:
        """The plan's time at a time of the bench."""
        if now_ns >= self.steady_ns or not self.ramp_ns:
            return self.steady_at_ns + (now_ns - self.steady_ns) * self.pace
        u = (now_ns - self.from_ns) / self.ramp_ns
        return self.at_ns + self.ramp_ns * (self.before * u + (self.pace - self.before) * u**3 * (1 - u / 2))

    def pace_at(self, now_ns: int) -> float:
        if now_ns >= self.steady_ns:
            return self.pace
        u = (now_ns - self.from_ns) / self.ramp_ns
        return self.before + (self.pace - self.before) * u * u * (3 - 2 * u)


class PhraseCourse:
    """Course of a phrase that begins at ``start_ns``.

    Long because each question of a place in time is answered over the same ramps of pace.
    """

    def __init__(
        self, phrase: Phrase, start_ns: int, rules: Mapping[str, AxisRules], pace: float, can_join: bool
    ) -> None:
        self.phrase, self._rules, self._can_join = phrase, rules, can_join
        self._starts = {
            name: [0, *accumulate(p.duration_ns for p in path)] for name, path in phrase.paths.items()
        }
        self.start_ns = start_ns
        self._leg = self._before = Leg(start_ns, 0.0, pace, pace)
        self._given_ns: int | None = None
        """Bench's time at which the pieces that were given end; None: they are all given."""

    @property
    def pace(self) -> float:
        """Pace that it has, or is changing to."""
        return self._leg.pace

    def is_steady(self, now_ns: int) -> bool:
        """True if its pace can be changed now, or more of it given."""
        return now_ns >= self._leg.steady_ns + BACK_NS

    def stands(self, now_ns: int) -> bool:
        """True if it is paused, and its axes stand, or has not begun."""
        return now_ns < self.start_ns or (self.pace == 0 and now_ns >= self._leg.steady_ns)

    def plan_ns(self, now_ns: int) -> int:
        """The plan's time at a time of the bench."""
        leg = self._leg if now_ns >= self._leg.from_ns else self._before
        return round(min(max(leg.plan_ns(now_ns), 0.0), self.phrase.duration_ns))

    def reached_ns(self, plan_ns: int, from_ns: int, now_ns: int) -> int:
        """Bench's time, between two, at which it came to a time of the plan."""
        while from_ns < now_ns:
            middle_ns = (from_ns + now_ns) // 2
            if self.plan_ns(middle_ns) >= plan_ns:
                now_ns = middle_ns
            else:
                from_ns = middle_ns + 1
        return now_ns

    def end_ns(self) -> int | None:
        """Bench's time at which it ends; None: it is paused."""
        left_ns = self.phrase.duration_ns - self._leg.steady_at_ns
        if self._leg.pace == 0:
            return None if left_ns > 0 else self._leg.steady_ns
        return self._leg.steady_ns + ceil(left_ns / self._leg.pace)

    # ---- a change of pace ----

    def change(self, pace: float, now_ns: int, lead_ns: int) -> bool:
        """Change the pace soon; False where the phrase ends before."""
        leg = self._leg
        from_ns = now_ns + lead_ns
        at_ns = leg.plan_ns(from_ns)
        ramp_ns, left_ns = self._ramp_ns(at_ns, leg.pace, pace), self.phrase.duration_ns - at_ns
        if ramp_ns * (leg.pace + pace) / 2 >= left_ns:
            if pace <= leg.pace or left_ns <= 0:
                return False
            ramp_ns = max(int(left_ns / (leg.pace + pace) * 2), 1)  # the path's end is slow anyway
        self._leg, self._before = Leg(from_ns, at_ns, leg.pace, pace, ramp_ns), leg
        return True

    def take_back(self) -> None:
        """Undo the last change of pace: its paths were not given in time."""
        self._leg = self._before

    @property
    def changes_ns(self) -> int:
        """Bench's time at which the last change of pace begins."""
        return self._leg.from_ns

    def _ramp_ns(self, at_ns: float, before: float, pace: float) -> int:
        """Duration of a change of pace that keeps the axes' accelerations on the way that it takes."""
        change = abs(pace - before)
        ramp_ns = LEAST_RAMP_NS
        for _ in range(8):
            slowest_s = 0.0
            until_ns = at_ns + ramp_ns * (before + pace) / 2
            for name in self.phrase.paths:
                fastest = self._fastest(name, at_ns, until_ns)
                slowest_s = max(slowest_s, fastest / (self._rules[name].acceleration_rpm_per_s * DEG_PER_S))
            wanted_ns = max(round(STEEPEST * change * slowest_s * NS_PER_S), LEAST_RAMP_NS)
            if wanted_ns <= ramp_ns:
                break
            ramp_ns = wanted_ns
        return ramp_ns

    def _fastest(self, name: str, from_ns: float, to_ns: float) -> float:
        """Largest speed of an axis between two times of the plan, at the ends of its pieces."""
        path, starts = self.phrase.paths[name], self._starts[name]
        first, last = bisect_right(starts, from_ns) - 1, bisect_right(starts, to_ns)
        return max(
            (
                abs(piece.after(at)[1])
                for piece in path[max(first, 0) : last]
                for at in (0, piece.duration_ns)
            ),
            default=0.0,
        )

    # ---- what the axes are given ----

    def first_paths(self) -> Mapping[str, Path]:
        """Paths to give before the start; long ones only their beginnings."""
        self._note_given(0.0)
        return {name: self._rest(name, 0.0, self._leg) for name in self.phrase.paths}

    def wants_more(self, now_ns: int) -> bool:
        """True if more of long paths has to be given."""
        given = self._given_ns
        return given is not None and now_ns >= given - AHEAD_NS and self.is_steady(now_ns)

    def behind_ns(self, now_ns: int) -> int:
        """Time since the end of what the axes were given of a long path; 0: they are not there yet."""
        return max(now_ns - self._given_ns, 0) if self._given_ns is not None else 0

    def paths(self, now_ns: int) -> tuple[int, Mapping[str, Path]]:
        """Paths from a little before now on, with the time at which they begin: those of a change of pace,
        or more of long ones."""
        leg, from_ns = self._leg, now_ns - BACK_NS
        made: dict[str, Path] = {}
        is_same = leg.steady_ns <= from_ns
        self._note_given(leg.plan_ns(from_ns) if is_same else leg.steady_at_ns)
        for name in self.phrase.paths:
            if is_same:
                made[name] = self._rest(name, leg.plan_ns(from_ns), leg)
            else:
                before = self._between(name, self._before.plan_ns(from_ns), leg.at_ns, self._before.pace)
                if self._before.pace == 0:
                    before = [PathPiece(leg.from_ns - from_ns, self._place(name, leg.at_ns)[0])]
                made[name] = (*before, *self._ramp(name), *self._rest(name, leg.steady_at_ns, leg))
        return from_ns, made

    # ---- another start ----

    def at_start(self, start_ns: int) -> "PhraseCourse":
        """The same course from another start on, with what the axes were given at first."""
        course = PhraseCourse(self.phrase, start_ns, self._rules, self.pace, self._can_join)
        course._note_given(0.0)
        return course

    def begin_again(
        self, begun_ns: Mapping[str, int], now_ns: int, lead_ns: int
    ) -> tuple["PhraseCourse", int, Mapping[str, Path]]:
        """Begin at another start, together: not all axes had their paths in time. Those that have begun, at
        ``begun_ns``, come back from ``lead_ns`` after now on, within their limits. Answers the course from
        the new start on, and the paths from a little before now on with the time at which they begin."""
        pace, from_ns, turn_ns = self.pace, now_ns - BACK_NS, now_ns + lead_ns
        begins_ns = {name: min(begun_ns.get(name, turn_ns), turn_ns) for name in self.phrase.paths}
        turns = {name: self._turn(name, (turn_ns - at_ns) * pace) for name, at_ns in begins_ns.items()}
        back_ns = max(self._back_ns(name, *turn) for name, turn in turns.items())
        course = self.at_start(turn_ns + back_ns)
        made: dict[str, Path] = {}
        for name, first in course.first_paths().items():
            at_ns, (turn_deg, speed), first_deg = begins_ns[name], turns[name], self._place(name, 0.0)[0]
            stood = PathPiece(max(at_ns - from_ns, 0), first_deg)
            went = self._between(name, max(from_ns - at_ns, 0) * pace, (turn_ns - at_ns) * pace, pace)
            stands_ns = turn_ns - max(from_ns, at_ns) - sum(piece.duration_ns for piece in went)
            back = _piece(back_ns, turn_deg, speed, first_deg, 0.0)
            made[name] = (stood, *went, PathPiece(max(stands_ns, 0), turn_deg), back, *first)
        return course, from_ns, made

    def _turn(self, name: str, at_ns: float) -> tuple[float, float]:
        """Place and speed of an axis at a time of the plan, on its way at this pace; at rest at 0."""
        at_deg, speed = self._place(name, at_ns)
        return at_deg, speed * self.pace if at_ns else 0.0

    def _back_ns(self, name: str, at_deg: float, speed: float) -> int:
        """Time in which an axis comes back to its first place and stands there, within its limits."""
        rules, way = self._rules[name], abs(at_deg - self._place(name, 0.0)[0])
        fastest, steepest = rules.velocity_rpm * DEG_PER_S, rules.acceleration_rpm_per_s * DEG_PER_S
        back_s = max(3 * way / fastest, 8 * abs(speed) / steepest, sqrt(12 * way / steepest))
        return max(ceil(back_s * NS_PER_S), LEAST_RAMP_NS)

    # ---- pieces ----

    def _ramp(self, name: str) -> list[PathPiece]:
        leg = self._leg
        count = ceil(leg.ramp_ns / STEP_NS)
        times = [leg.from_ns + leg.ramp_ns * step // count for step in range(count + 1)]
        pieces = []
        at_deg, speed = self._place(name, leg.plan_ns(times[0]))
        speed *= leg.pace_at(times[0])
        for from_ns, to_ns in pairwise(times):
            to_deg, to_speed = self._place(name, leg.plan_ns(to_ns))
            to_speed *= leg.pace_at(to_ns)
            pieces.append(_piece(to_ns - from_ns, at_deg, speed, to_deg, to_speed))
            at_deg, speed = to_deg, to_speed
        return pieces

    def _place(self, name: str, at_ns: float) -> tuple[float, float]:
        """Place and speed of an axis at a time of the plan."""
        path, starts = self.phrase.paths[name], self._starts[name]
        number = min(max(bisect_right(starts, at_ns) - 1, 0), len(path) - 1)
        piece, t = path[number], (at_ns - starts[number]) / NS_PER_S
        if at_ns >= starts[-1]:
            return path[-1].r, 0.0
        return (
            piece.r + t * (piece.per_s + t * (piece.per_s2 / 2 + t * piece.per_s3 / 6)),
            piece.per_s + t * (piece.per_s2 + t * piece.per_s3 / 2),
        )

    def _rest(self, name: str, at_ns: float, leg: Leg) -> Path:
        """Path from a time of the plan on, as far as it is given at once."""
        path, starts = self.phrase.paths[name], self._starts[name]
        if leg.pace == 0:
            return (PathPiece(0, self._place(name, at_ns)[0]),)
        until_ns = self._window_ns(at_ns)
        if at_ns == 0 and until_ns >= starts[-1] and leg.pace == 1:
            return path
        pieces = self._between(name, at_ns, until_ns, leg.pace)
        return (*pieces, PathPiece(0, self._place(name, until_ns)[0]))

    def _window_ns(self, at_ns: float) -> float:
        """The plan's time up to which pieces are given from a time on, alike for all axes."""
        until_ns = float(self.phrase.duration_ns)
        if not self._can_join:
            return until_ns
        for starts in self._starts.values():
            last = bisect_right(starts, at_ns) + PIECES
            if last < len(starts):
                until_ns = min(until_ns, max(float(starts[last]), at_ns + LEAST_S * NS_PER_S))
        return until_ns

    def _between(self, name: str, from_ns: float, to_ns: float, pace: float) -> list[PathPiece]:
        """Pieces of an axis between two times of the plan, at a pace above 0."""
        path, starts = self.phrase.paths[name], self._starts[name]
        pieces: list[PathPiece] = []
        if pace == 0:
            return pieces
        number = min(max(bisect_right(starts, from_ns) - 1, 0), len(path) - 1)
        done_ns, at_ns = 0, from_ns
        while at_ns < to_ns and number < len(path):
            end_ns = min(float(starts[number + 1]), to_ns)
            until_ns = round((end_ns - from_ns) / pace)
            if until_ns > done_ns:
                piece, t = path[number], (at_ns - starts[number]) / NS_PER_S
                r = piece.r + t * (piece.per_s + t * (piece.per_s2 / 2 + t * piece.per_s3 / 6))
                per_s = piece.per_s + t * (piece.per_s2 + t * piece.per_s3 / 2)
                per_s2 = piece.per_s2 + t * piece.per_s3
                pieces.append(
                    PathPiece(until_ns - done_ns, r, per_s * pace, per_s2 * pace**2, piece.per_s3 * pace**3)
                )
                done_ns = until_ns
            at_ns, number = end_ns, number + 1
        return pieces

    def _note_given(self, at_ns: float) -> None:
        """Note the bench's time that the pieces reach which are given from ``at_ns`` of the plan on."""
        leg, until_ns = self._leg, self._window_ns(at_ns)
        is_all = until_ns >= self.phrase.duration_ns or leg.pace == 0
        self._given_ns = None if is_all else leg.steady_ns + round((until_ns - leg.steady_at_ns) / leg.pace)


def _piece(duration_ns: int, at_deg: float, speed: float, to_deg: float, to_speed: float) -> PathPiece:
    """Piece from a place and speed to another place and speed."""
    t, way = duration_ns / NS_PER_S, to_deg - at_deg
    per_s2 = (6 * way - 2 * t * (2 * speed + to_speed)) / t**2
    per_s3 = (6 * t * (speed + to_speed) - 12 * way) / t**3
    return PathPiece(duration_ns, at_deg, speed, per_s2, per_s3)
