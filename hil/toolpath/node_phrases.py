"""Plan of a path as phrases of commands for the nodes of a line, piece by piece as they are needed."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from typing import NamedTuple

from hil.gcode.canonical import Place
from hil.toolpath.line_load import line_load
from hil.toolpath.machine import Machine
from hil.toolpath.path_items import Chord, Item, Position
from hil.toolpath.path_plan import PathPlan, PlannedStretch
from hil.toolpath.path_speeds import Segment, limits_of
from hil.vocab.path_planning import AxisMotion, NodeCommand, PathPlanner

LONGEST_REST_S = 10.0
"""Longest time for which an axis rests within a phrase: its next command has to be there when it begins to
rest. The phrase ends before an axis moves that has rested longer."""

Pulses = Mapping[str, int]
"""Pulses from the machine's zero, by the letters of axes."""


class PlacedCommand(NamedTuple):
    """Command of a phrase, and the place in the program that it is of."""

    command: NodeCommand
    place: Place


@dataclass(frozen=True)
class PathPhrase:
    """Commands from a rest to a rest, made as they are taken, in the order in which they are to be sent.

    ``ahead`` is the number of commands of each axis that are to be at the boards before the release. The axes
    stand at ``begin`` before it and at ``end`` after it.
    """

    commands: Iterator[PlacedCommand]
    ahead: int
    duration_s: float
    begin: Pulses
    end: Pulses
    place: Place


class NodePhrases:
    """Maker of the phrases of a plan, all of whose axes are nodes of a line.

    Raises:
        ValueError: an axis has no node.
    """

    def __init__(self, machine: Machine, planner: PathPlanner) -> None:
        if not machine.has_nodes:
            raise ValueError(f"{machine.name} has axes without a node")
        self._machine, self._planner = machine, planner
        self._axes = {axis.letter: axis.stepper for axis in machine.axes}

    def of(self, plan: PathPlan) -> Iterator[PathPhrase | Item]:
        """Phrases of a plan, and what is between them."""
        for item in plan.items:
            if isinstance(item, PlannedStretch):
                yield from self._stretch(item)
            else:
                yield item

    def pulses_at(self, position: Position) -> dict[str, int]:
        """Pulses from the machine's zero at which a position is."""
        return {
            axis.letter: axis.pulses_at(place)
            for axis, place in zip(self._machine.axes, position, strict=True)
        }

    def _stretch(self, planned: PlannedStretch) -> Iterator[PathPhrase]:
        if planned.is_streamed:
            yield from self._stream(planned)
            return
        here = planned.stretch.begin
        for chord in planned.stretch.chords:
            if phrase := self._line(here, chord, planned.override):
                yield phrase
            here = chord.end

    def _line(self, here: Position, chord: Chord, override: float) -> PathPhrase | None:
        """Make a line with ramps; None: it is less than a pulse."""
        begin, end = self.pulses_at(here), self.pulses_at(chord.end)
        limits = limits_of(chord, self._machine.axes)
        speed_per_s = min(chord.asked_per_s * override, limits.speed_per_s)
        motions = {}
        for axis, way in zip(self._machine.axes, chord.way, strict=True):
            if pulses := end[axis.letter] - begin[axis.letter]:
                # A pulse at least: an axis whose way is only rounding goes with the others, at their time.
                part = max(abs(way * axis.pulses_per_unit), abs(pulses)) / chord.length
                motions[axis.letter] = AxisMotion(
                    axis.stepper, pulses, speed_per_s * part, limits.acceleration_per_s2 * part
                )
        if not motions:
            return None
        phrase = self._planner.line(motions)
        commands = (PlacedCommand(command, chord.place) for command in phrase.commands)
        ahead = self._planner.queue_length - 1
        return PathPhrase(commands, ahead, phrase.duration_us / 1e6, begin, end, chord.place)

    def _stream(self, planned: PlannedStretch) -> Iterator[PathPhrase]:
        segments = list(planned.segments(self._machine.segment_s))
        here = planned.stretch.begin
        for part in _parts(segments, self._moving(here, segments)):
            ahead = line_load(self._machine, here, part).ahead
            chords = planned.stretch.chords
            begin, end = self.pulses_at(here), self.pulses_at(part[-1].end)
            commands = self._commands(planned, begin, part)
            duration_s = sum(segment.duration_s for segment in part)
            yield PathPhrase(commands, ahead, duration_s, begin, end, chords[part[0].chord].place)
            here = part[-1].end

    def _moving(self, here: Position, segments: Sequence[Segment]) -> Iterator[list[str]]:
        """Axes that move in each segment."""
        before = self.pulses_at(here)
        for segment in segments:
            there = self.pulses_at(segment.end)
            yield [letter for letter in there if there[letter] != before[letter]]
            before = there

    def _commands(
        self, planned: PlannedStretch, begin: Pulses, segments: Sequence[Segment]
    ) -> Iterator[PlacedCommand]:
        stream = self._planner.stream(self._axes)
        waiting: list[tuple[float, int, PlacedCommand]] = []
        before, count = begin, 0
        for segment in segments:
            there = self.pulses_at(segment.end)
            made = stream.add(
                segment.duration_s * 1e6, {letter: there[letter] - before[letter] for letter in there}
            )
            before = there
            for command in made:
                placed = PlacedCommand(command, planned.stretch.chords[segment.chord].place)
                heappush(waiting, (command.needed_us, count, placed))
                count += 1
            while waiting and waiting[0][0] < stream.at_us - LONGEST_REST_S * 1e6:
                yield heappop(waiting)[2]
        while waiting:
            yield heappop(waiting)[2]


def _parts(segments: Sequence[Segment], moving: Iterator[list[str]]) -> Iterator[list[Segment]]:
    """Divide segments before an axis moves that has rested for longer than ``LONGEST_REST_S``."""
    part: list[Segment] = []
    moved_s: dict[str, float] = {}
    at_s = 0.0
    for segment, letters in zip(segments, moving, strict=True):
        if part and any(at_s - moved_s.get(letter, 0.0) > LONGEST_REST_S for letter in letters):
            yield part
            part, at_s, moved_s = [], 0.0, {}
        part.append(segment)
        at_s += segment.duration_s
        moved_s |= dict.fromkeys(letters, at_s)
    if part:
        yield part
