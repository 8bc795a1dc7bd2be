"""Plan of a whole program: what happens one after the other, how long it takes, what is to be said of it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from hil.gcode.canonical import Arc, Canonical, Dwell, Point, Program, Straight, TextPlace
from hil.toolpath.line_load import LineLoad, line_load
from hil.toolpath.machine import Machine
from hil.toolpath.motion_check import LONGEST_S, MOST_CHORDS, check_motions
from hil.toolpath.path_items import Item, Position, Stretch
from hil.toolpath.path_speeds import ChordSpeed, StreamSegment, limits_of, segments, stops_s, stretch_speeds
from hil.vocab.problem import Problem

ORIGIN = Point()
LONGEST_LINE_S = 10.0
"""Longest line that is done with the boards' own ramps, which only end at its end. A longer one is streamed,
and can brake."""
LONGEST_STREAM = 2_000_000
"""Longest stretch that is streamed to nodes, in its shortest segments: 2.8 hours of 5 ms. One takes 300
bytes."""
LEAST_SLOWER = 1e-6
"""Share by which a speed has to be below what is asked for to be told."""


@dataclass(frozen=True)
class PlannedStretch:
    """Stretch with its speeds. ``is_streamed``: in short segments without a stop; else the machine stops at
    the end of each chord, which has ramps of its own."""

    stretch: Stretch
    speeds: Sequence[ChordSpeed]
    is_streamed: bool
    duration_s: float
    override: float = 1.0

    def segments(self, machine: Machine) -> Iterator[StreamSegment]:
        """Segments of constant speed of this machine's axes."""
        return segments(self.stretch, self.speeds, machine.segment_s, machine.axes)

    def samples(self, every_s: float) -> Iterator[tuple[float, Position, TextPlace]]:
        """Time, position and place in the program at the beginning, at every multiple of ``every_s``, and at
        the end; of a stretch that is not streamed only if it is one chord."""
        here, before_s, number = self.stretch.begin, 0.0, 0
        for chord, speed in zip(self.stretch.chords, self.speeds, strict=True):
            duration_s = speed.duration_s
            while (at_s := number * every_s - before_s) < duration_s:
                part = speed.part_at(at_s)
                place = tuple(a + part * b for a, b in zip(here, chord.way, strict=True))
                yield number * every_s, place, chord.place
                number += 1
            here, before_s = chord.end, before_s + duration_s
        yield before_s, here, self.stretch.chords[-1].place

    @property
    def end(self) -> tuple[float, ...]:
        return self.stretch.chords[-1].end


@dataclass
class PathPlan:
    """Plan of a program. With problems there are no items, and nothing may move."""

    machine: Machine
    file: str
    override: float = 1.0
    items: list[PlannedStretch | Item] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    remarks: list[Problem] = field(default_factory=list)

    @property
    def stretches(self) -> Iterator[PlannedStretch]:
        return (item for item in self.items if isinstance(item, PlannedStretch))

    @cached_property
    def duration_s(self) -> float:
        """Time of all motions and dwells; what a line takes between them is not in it."""
        dwells_s = sum(item.seconds for item in self.items if isinstance(item, Dwell))
        return dwells_s + sum(stretch.duration_s for stretch in self.stretches)

    def length(self, *, is_rapid: bool) -> float:
        """Length of the rapids, or of all other motions: millimetres, and degrees of rotary axes alone."""
        return sum(
            chord.length
            for each in self.stretches
            if each.stretch.is_rapid == is_rapid
            for chord in each.stretch.chords
        )

    def extents(self) -> dict[str, tuple[float, float]]:
        """Smallest and largest positions of each axis, by its letter."""
        places = [chord.end for each in self.stretches for chord in each.stretch.chords]
        if first := next(self.stretches, None):
            places.append(first.stretch.begin)
        columns = zip(*places, strict=True)
        letters = [axis.letter for axis in self.machine.axes]
        return {letter: (min(each), max(each)) for letter, each in zip(letters, columns, strict=False)}

    @cached_property
    def line_load(self) -> LineLoad | None:
        """Load of a line of SACs by the busiest stretch; None: nothing is streamed over a line."""
        loads = [
            line_load(self.machine, each.stretch.begin, list(each.segments(self.machine)))
            for each in self.stretches
            if each.is_streamed and self.machine.has_nodes
        ]
        return min(loads, key=lambda load: load.margin_s, default=None)


def plan_path(
    motions: Sequence[Canonical],
    machine: Machine,
    file: str,
    begin: Point = ORIGIN,
    override: float = 1.0,
    most_chords: int = MOST_CHORDS,
) -> PathPlan:
    """Check motions against a machine that stands at ``begin``, and plan them; ``override`` is a factor on
    all feeds."""
    checked = check_motions(motions, machine, file, begin, most_chords)
    plan = PathPlan(machine, file, override, problems=checked.problems, remarks=checked.remarks)
    if plan.problems:
        return plan
    for item in checked.items:
        plan.items.append(planned(item, machine, override) if isinstance(item, Stretch) else item)
    plan.problems += _too_long(plan)
    if plan.problems:
        plan.items.clear()
        return plan
    plan.remarks += _slower(plan)
    return plan


def _too_long(plan: PathPlan) -> Iterator[Problem]:
    """Problems of a program longer than a day, and of stretches that are too long to be streamed to nodes."""
    left_s, segment_s = LONGEST_S, plan.machine.segment_s
    for item in plan.items:
        place: TextPlace | None = None
        if isinstance(item, Dwell):
            place, lasts_s = item.place, item.seconds
        elif isinstance(item, PlannedStretch):
            place, lasts_s = _place_at(item, left_s), item.duration_s
            if plan.machine.has_nodes and item.is_streamed and lasts_s > LONGEST_STREAM * segment_s:
                what = f"it is {lasts_s / 3600:.3g} hours from here to the next stop"
                remedy = f"stop within {LONGEST_STREAM * segment_s / 3600:.3g} hours: G4 P0"
                yield Problem(plan.file, *item.stretch.chords[0].place, what, remedy)
        if place is None:
            continue
        if lasts_s > left_s:
            what = "the program takes over a day up to here"
            yield Problem(
                plan.file, *place, what, "check its feeds and dwells, or make several programs of it"
            )
            return
        left_s -= lasts_s


def _place_at(planned: PlannedStretch, at_s: float) -> TextPlace:
    """Place in the program of what a stretch does at a time, if it is streamed."""
    for chord, speed in zip(planned.stretch.chords, planned.speeds, strict=True):
        at_s -= speed.duration_s
        if at_s < 0:
            return chord.place
    return planned.stretch.chords[-1].place


def plan_program(
    program: Program,
    machine: Machine,
    file: str,
    begin: Point = ORIGIN,
    override: float = 1.0,
    most_chords: int = MOST_CHORDS,
) -> PathPlan:
    """Plan a program as ``plan_path``. The plan of one with problems has these, and what the machine cannot
    do of the motions that were understood, in the order of the text."""
    if not program.problems:
        return plan_path(program.motions, machine, file, begin, override, most_chords)
    checkable = [_plain(motion) for motion in program.understood]
    found = [*program.problems, *check_motions(checkable, machine, file, begin, most_chords).problems]
    found.sort(key=lambda problem: (problem.line, problem.column))
    return PathPlan(machine, file, override, problems=found)


def _plain(motion: Canonical) -> Canonical:
    """Motion for a check of its end alone, where its feed was not understood."""
    if isinstance(motion, Arc) and not motion.feed.value:
        return Straight(motion.place, is_rapid=True, end=motion.end, feed=None)
    return motion


def planned(stretch: Stretch, machine: Machine, override: float = 1.0) -> PlannedStretch:
    """Plan the speeds of a stretch: streamed, or with a stop after each chord if that is quicker."""
    speeds = stretch_speeds(stretch, machine.axes, machine.segment_s, override)
    stream_s = sum(speed.duration_s for speed in speeds)
    if len(stretch.chords) == 1:
        return PlannedStretch(stretch, speeds, stream_s > LONGEST_LINE_S, stream_s, override)
    all_stops_s = stops_s(stretch, machine.axes, override) + len(stretch.chords) * machine.stop_s
    is_streamed = stream_s + machine.stop_s <= all_stops_s
    return PlannedStretch(stretch, speeds, is_streamed, stream_s if is_streamed else all_stops_s, override)


def _slower(plan: PathPlan) -> Iterator[Problem]:
    """Remarks on feeds that the axes cannot do, one for each axis, at its first place."""
    found: dict[str, tuple[Problem, int]] = {}
    for each in plan.stretches:
        if each.stretch.is_rapid:
            continue
        for chord in each.stretch.chords:
            limit = limits_of(chord, plan.machine.axes)
            if chord.asked_per_s <= limit.speed_per_s * (1 + LEAST_SLOWER):
                continue
            letter = limit.slowest.letter.upper()
            if letter not in found:
                what = f"F{chord.asked_per_s * 60:.6g} is too fast for {letter}"
                remedy = f"it is done with {limit.speed_per_s * 60:.6g} a minute"
                found[letter] = (Problem(plan.file, *chord.place, what, remedy), 0)
            problem, count = found[letter]
            found[letter] = (problem, count + 1)
    for problem, count in found.values():
        more = f", here and in {count - 1} other pieces" if count > 2 else ""
        yield replace(problem, message=problem.message + more)
