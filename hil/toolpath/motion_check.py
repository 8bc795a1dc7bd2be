"""Canonical motions against a machine: every problem with its place, and the path in straight pieces."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from math import acos, atan2, ceil, cos, hypot, inf, pi, sin, sqrt

from hil.gcode.canonical import (
    PLANE_AXES,
    Arc,
    Canonical,
    Feed,
    PathMode,
    Point,
    Straight,
    Switch,
    TextPlace,
)
from hil.toolpath.machine import LETTERS, Machine, MachineAxis
from hil.toolpath.path_items import Chord, Item, Position, Stretch, joined
from hil.vocab.problem import Problem

ORIGIN = Point()
MOST_SHARE, LEAST_SHARE, PULSES = 0.75, 0.25, 1.25
"""Shares of the tolerance that straight pieces use at most and at least; what is between them depends on the
number of pulses that whole pulses may be off the path."""
LIMIT_SLACK = 1e-6
"""Distance beyond a limit that comes from rounding alone, in millimetres or degrees."""
CLOSED = 1e-9
"""Distance of an arc's ends with which it is a whole circle."""
LEAST_CHORDS_OF_TURN = 12
MOST_FINER = 4
"""Number of times that the pieces of a slow arc are shorter than its tolerance asks for, at most."""
MOST_CHORDS = 1_000_000
"""Maximum number of straight pieces of a program, all its arcs together. One takes a kilobyte, and some 50 us
of planning."""
LONGEST_S = 86_400.0
"""Longest motion, and longest program, a day: a longer one is a mistake in the feed."""
MOST_PROBLEMS = 1000
"""Maximum number of problems that are listed."""
_LINEAR, _SECOND, _ROTARY = 0, 1, 2
_MEASURE = {**dict.fromkeys("xyz", _LINEAR), **dict.fromkeys("uvw", _SECOND), **dict.fromkeys("abc", _ROTARY)}


@dataclass
class CheckedPath:
    """Path of a program. ``items`` are of use without a problem only."""

    items: list[Item] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    remarks: list[Problem] = field(default_factory=list)


def check_motions(
    motions: Iterable[Canonical],
    machine: Machine,
    file: str,
    begin: Point = ORIGIN,
    most_chords: int = MOST_CHORDS,
) -> CheckedPath:
    """Compare motions with a machine that stands at ``begin``, and make straight pieces of them. What is
    behind the motion that needs one too many is not looked at."""
    check = MotionCheck(machine, file, begin, most_chords)
    for motion in motions:
        check.feed(motion)
        if check.is_full:
            break
    check.finish()
    return check.path


class MotionCheck:
    """Reader of motions, one after the other.

    Long because pieces that touch are checked against each other, and a rest closes all of them.
    """

    def __init__(self, machine: Machine, file: str, begin: Point, most_chords: int = MOST_CHORDS) -> None:
        self.path = CheckedPath()
        self.is_full = False
        self._most_chords, self._chords_left = most_chords, most_chords
        self._machine, self._file = machine, file
        self._here = begin
        self._axes = machine.axes
        self._indices = [axis.index for axis in self._axes]
        self._others = [index for index in range(len(LETTERS)) if index not in self._indices]
        self._measures = [_MEASURE[axis.letter] for axis in self._axes]
        self._rapid_per_s = (machine.text.rapid_mm_per_min or inf) / 60
        self._pulse = max(
            (1 / abs(axis.pulses_per_unit) for axis in self._axes if axis.pulses_per_unit), default=0.0
        )
        """Largest pulse of an axis, in millimetres or degrees."""
        self._spindle_rpm: float | None = None
        self._mode = "blend"
        self._tolerance = machine.text.tolerance_mm
        self._chords: list[Chord] = []
        self._stretch_begin: Position = self._position(begin)
        self._is_rapid = False
        self._switches_said: set[str] = set()
        self._tolerances_said: set[float] = set()

    # ---- what comes ----

    def feed(self, motion: Canonical) -> None:
        """Take the next motion."""
        match motion:
            case Straight():
                self._straight(motion)
            case Arc():
                self._arc(motion)
            case PathMode():
                self._close()
                self._mode = motion.kind
                self._tolerance = motion.tolerance_mm or self._machine.text.tolerance_mm
            case Switch():
                self._switch(motion)
            case _:
                self._close()
                self.path.items.append(motion)

    def finish(self) -> None:
        """End the path."""
        self._close()
        self.path.problems.sort(key=lambda problem: (problem.line, problem.column))
        del self.path.problems[MOST_PROBLEMS:]

    def _straight(self, motion: Straight) -> None:
        if not self._can_be_at(motion.place, motion.end):
            self._here = motion.end
            return
        if motion.is_rapid != self._is_rapid or motion.is_rapid or self._mode == "exact_stop":
            self._close()
        self._is_rapid = motion.is_rapid
        begin, end = self._position(self._here), self._position(motion.end)
        self._here = motion.end
        way = tuple(b - a for a, b in zip(begin, end, strict=True))
        measure, length = self._length(way)
        if length == 0:
            return
        asked = self._asked_per_s(motion.place, motion.feed, length)
        if asked is not None:
            self._add(end, way, length, measure, asked, motion.place, is_arc=False)

    def _arc(self, motion: Arc) -> None:
        if self._is_rapid or self._mode == "exact_stop":
            self._close()
        self._is_rapid = False
        begin, self._here = self._here, motion.end
        if not self._can_be_at(motion.place, motion.end) or not self._can_pass(motion, begin):
            return
        length = arc_length(begin, motion)
        asked = self._asked_per_s(motion.place, motion.feed, length)
        if asked is None:
            return
        most_per_s = min(asked, *(axis.speed_per_s for axis in self._axes))
        tolerance, longest = self._for_pieces(self._tolerance_now()), most_per_s * self._machine.segment_s
        if arc_pieces(begin, motion, tolerance, longest) > self._chords_left:
            self._full(motion.place)
            return
        here = self._position(begin)
        for point in arc_points(begin, motion, tolerance, longest):
            position = self._position(point)
            way = tuple(b - a for a, b in zip(here, position, strict=True))
            measure, length = self._length(way)
            if length:
                self._add(position, way, length, measure, asked, motion.place, is_arc=True)
            here = position

    def _switch(self, motion: Switch) -> None:
        self._close()
        if motion.name == "spindle":
            self._spindle_rpm = motion.speed_rpm if motion.state != "off" else None
        switch = getattr(self._machine.text.switches, motion.name)
        if switch is None:
            if motion.state != "off" and motion.name not in self._switches_said:
                what = f"the machine has no switch for {motion.name}"
                self.path.remarks.append(
                    Problem(
                        self._file, *motion.place, what, f"nothing is switched; add switches.{motion.name}:"
                    )
                )
                self._switches_said.add(motion.name)
            return
        if motion.state == "ccw" and switch.start_ccw is None:
            self._find(motion.place, "this spindle turns one way", "use M3, or add start_ccw: to the machine")
        self.path.items.append(motion)

    # ---- pieces ----

    def _add(
        self,
        end: Position,
        way: Position,
        length: float,
        measure: int,
        asked_per_s: float,
        place: TextPlace,
        *,
        is_arc: bool,
    ) -> None:
        if length / asked_per_s > LONGEST_S:
            what = f"this motion would take {length / asked_per_s / 86_400:.3g} days"
            self._find(place, what, "check the feed: a day is the most")
            return
        if not self._chords_left:
            self._full(place)
            return
        self._chords_left -= 1
        self._chords.append(Chord(end, way, length, measure, asked_per_s, place, is_arc))

    def _close(self) -> None:
        """End the stretch, where the machine stops."""
        if self._chords:
            chords = self._chords
            tolerance = self._tolerance if self._mode == "blend" and not self._is_rapid else 0.0
            if tolerance and len(chords) > 1:
                self._check_tolerance(chords[0].place, tolerance)
                chords = joined(
                    self._stretch_begin,
                    chords,
                    self._for_pieces(tolerance),
                    self._machine.segment_s,
                    self._length,
                )
            self.path.items.append(Stretch(self._stretch_begin, chords, self._is_rapid, tolerance))
            self._chords = []
        self._stretch_begin = self._position(self._here)

    def _check_tolerance(self, place: TextPlace, tolerance: float) -> None:
        """Say once of a tolerance that whole pulses cannot keep it."""
        if tolerance < (least := PULSES * self._pulse) and tolerance not in self._tolerances_said:
            self._tolerances_said.add(tolerance)
            what = f"a tolerance of {tolerance:.4g} mm is less than {PULSES:g} pulses of an axis"
            remedy = f"the path may be {least:.3g} mm off; allow that, or use more microsteps"
            self.path.remarks.append(Problem(self._file, *place, what, remedy))

    def _for_pieces(self, tolerance: float) -> float:
        """Part of a tolerance that straight pieces may use."""
        return max(min(MOST_SHARE * tolerance, tolerance - PULSES * self._pulse), LEAST_SHARE * tolerance)

    def _tolerance_now(self) -> float:
        return self._tolerance if self._mode == "blend" else self._machine.text.tolerance_mm

    def _position(self, point: Point) -> Position:
        return tuple(point[index] for index in self._indices)

    def _length(self, way: Position) -> tuple[int, float]:
        """Measure of a way (``PathItem.measure``) and its length in that."""
        squares = [0.0, 0.0, 0.0]
        for measure, each in zip(self._measures, way, strict=True):
            squares[measure] += each * each
        measure = next((kind for kind, square in enumerate(squares) if square), _LINEAR)
        return measure, sqrt(squares[measure])

    def _asked_per_s(self, place: TextPlace, feed: Feed | None, length: float) -> float | None:
        """Speed that a motion asks for, along its path."""
        if feed is None:
            return self._rapid_per_s
        if feed.kind == "per_minute":
            return feed.value / 60
        if feed.kind == "inverse_time":
            return length * feed.value / 60
        if not self._spindle_rpm:
            self._find(
                place, "a feed for each turn, and the spindle does not turn", "write M3 S... before it"
            )
            return None
        return feed.value * self._spindle_rpm / 60

    # ---- what is wrong ----

    def _can_be_at(self, place: TextPlace, end: Point) -> bool:
        is_good = True
        here = self._here
        for index in self._others:
            if end[index] != here[index]:
                what = f"the machine has no axis {LETTERS[index].upper()}"
                self._find(place, what, f"leave {LETTERS[index].upper()} out, or add it to the machine")
                is_good = False
        for axis in self._axes:
            position = end[axis.index]
            is_inside = axis.minimum - LIMIT_SLACK <= position <= axis.maximum + LIMIT_SLACK
            if not is_inside and position != here[axis.index]:  # once, where it leaves
                self._outside(place, axis, position, "would go to")
                is_good = False
        return is_good

    def _can_pass(self, motion: Arc, begin: Point) -> bool:
        """Check the farthest points of an arc between its ends."""
        is_good = True
        first, second, _ = PLANE_AXES[motion.plane]
        by_index = {axis.index: axis for axis in self._axes}
        for index in (first, second):
            if index not in by_index:
                what = f"the machine has no axis {LETTERS[index].upper()}"
                self._find(motion.place, what, "an arc needs both axes of its plane")
                is_good = False
        for index, position in arc_extremes(begin, motion) if is_good else ():
            axis = by_index[index]
            if not axis.minimum - LIMIT_SLACK <= position <= axis.maximum + LIMIT_SLACK:
                self._outside(motion.place, axis, position, "would pass")
                is_good = False
        return is_good

    def _outside(self, place: TextPlace, axis: MachineAxis, position: float, verb: str) -> None:
        what = f"{axis.letter.upper()} {verb} {position:.6g} {axis.unit}"
        self._find(place, what, f"write {axis.minimum:g} to {axis.maximum:g}")

    def _full(self, place: TextPlace) -> None:
        if not self.is_full:
            self.is_full = True
            what = f"the path up to here needs over {self._most_chords} straight pieces"
            self._find(place, what, "allow a larger tolerance, or make several programs of it")

    def _find(self, place: TextPlace, message: str, remedy: str) -> None:
        self.path.problems.append(Problem(self._file, place.line, place.column, message, remedy))


# ---- arcs ----


def _sweep(begin: Point, arc: Arc) -> tuple[float, float]:
    """Angle at which an arc begins, and the signed angle that it goes through, in radians."""
    first, second, _ = PLANE_AXES[arc.plane]
    start = atan2(begin[second] - arc.centre[1], begin[first] - arc.centre[0])
    end = atan2(arc.end[second] - arc.centre[1], arc.end[first] - arc.centre[0])
    is_closed = hypot(arc.end[first] - begin[first], arc.end[second] - begin[second]) <= CLOSED
    sign = 1 if arc.turns > 0 else -1
    part = 2 * pi if is_closed else (sign * (end - start)) % (2 * pi)
    return start, sign * (part + 2 * pi * (abs(arc.turns) - 1))


def arc_length(begin: Point, arc: Arc) -> float:
    """Length of an arc, of a helix along its way."""
    first, second, across = PLANE_AXES[arc.plane]
    _, sweep = _sweep(begin, arc)
    radius = hypot(begin[first] - arc.centre[0], begin[second] - arc.centre[1])
    return hypot(radius * sweep, arc.end[across] - begin[across])


def arc_pieces(begin: Point, arc: Arc, tolerance: float, longest: float = inf) -> int:
    """Number of straight pieces of an arc that are within the tolerance of it, and not longer than
    ``longest`` unless they would be tiny."""
    _, sweep = _sweep(begin, arc)
    most = max(*_radii(begin, arc), CLOSED)
    each = min(2 * acos(max(1 - tolerance / most, 0.0)), 2 * pi / LEAST_CHORDS_OF_TURN)
    each = min(each, max(longest / most, each / MOST_FINER))
    return max(ceil(abs(sweep) / max(each, 1e-7)), 1)


def arc_points(begin: Point, arc: Arc, tolerance: float, longest: float = inf) -> Iterator[Point]:
    """Points between the pieces of an arc, the last one its end, one after the other: there may be many."""
    first, second, _ = PLANE_AXES[arc.plane]
    start, sweep = _sweep(begin, arc)
    radius, end_radius = _radii(begin, arc)
    count = arc_pieces(begin, arc, tolerance, longest)
    for number in range(1, count):
        part = number / count
        angle, r = start + part * sweep, radius + part * (end_radius - radius)
        point = [a + part * (b - a) for a, b in zip(begin, arc.end, strict=True)]
        point[first] = arc.centre[0] + r * cos(angle)
        point[second] = arc.centre[1] + r * sin(angle)
        yield Point(*point)
    yield arc.end


def _radii(begin: Point, arc: Arc) -> tuple[float, float]:
    """Distances of an arc's ends from its centre, in its plane."""
    first, second, _ = PLANE_AXES[arc.plane]
    ends = (hypot(each[first] - arc.centre[0], each[second] - arc.centre[1]) for each in (begin, arc.end))
    return next(ends), next(ends)


def arc_extremes(begin: Point, arc: Arc) -> Iterator[tuple[int, float]]:
    """Farthest positions of an arc in its plane between its ends, by the indices of their axes."""
    first, second, _ = PLANE_AXES[arc.plane]
    start, sweep = _sweep(begin, arc)
    radius = hypot(begin[first] - arc.centre[0], begin[second] - arc.centre[1])
    end_radius = hypot(arc.end[first] - arc.centre[0], arc.end[second] - arc.centre[1])
    low, high = sorted((start, start + sweep))
    for quarter in range(4):
        angle = quarter * pi / 2
        angle += 2 * pi * ceil((low - angle) / (2 * pi))
        while angle <= high:  # in each turn: the radii of both ends may differ a little
            r = radius + (angle - start) / sweep * (end_radius - radius)
            which = quarter % 2
            yield (first, second)[which], arc.centre[which] + (r if quarter < 2 else -r)
            angle += 2 * pi * max(int((high - angle) / (2 * pi)), 1)
