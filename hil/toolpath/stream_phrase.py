"""Phrase of a stream: commands that are made as they are taken, until it ends or brakes."""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from heapq import heapify, heappop, heappush
from typing import NamedTuple

from hil.gcode.canonical import TextPlace
from hil.toolpath.machine import Machine
from hil.toolpath.path_items import Stretch
from hil.toolpath.path_plan import PlannedStretch
from hil.toolpath.path_rest import brake_from
from hil.toolpath.path_speeds import StreamSegment, segments
from hil.vocab.path_planning import NodeCommand, PathPlanner

LONGEST_REST_S = 10.0
"""Longest time for which an axis rests within a phrase: its next command has to be there when it begins to
rest. The phrase ends before an axis moves that has rested longer."""
WORTH_BRAKING_S = 0.3
"""Time to the end of a phrase from which on braking saves something."""

Pulses = Mapping[str, int]
"""Pulses from the machine's zero, by the letters of axes."""


class PlacedCommand(NamedTuple):
    """Command of a phrase, and the place in the program that it is of."""

    command: NodeCommand
    place: TextPlace


class _Waiting(NamedTuple):
    """Command that nobody has taken yet."""

    needed_us: float
    number: int
    segment: int
    placed: PlacedCommand


class StreamPhrase:
    """Commands from a rest to a rest, in the order in which they are to be sent.

    ``ahead`` is the number of commands of each axis that are to be at the boards before the release. The axes
    stand at ``begin`` before it and at ``end`` after it. ``brake`` changes ``end``, ``duration_s``, and
    ``rest``: what is left of the stretch.
    """

    def __init__(
        self,
        machine: Machine,
        planner: PathPlanner,
        planned: PlannedStretch,
        begin: Sequence[float],
        parts: Sequence[StreamSegment],
        ahead: int,
    ) -> None:
        self.ahead = ahead
        self.is_braked = False
        self.rest: Stretch | None = None
        self.place = planned.stretch.chords[parts[0].chord].place
        self._machine, self._planned = machine, planned
        self._chords, self._segments = list(planned.stretch.chords), list(parts)
        self._stream = planner.stream({axis.letter: axis.stepper for axis in machine.axes})
        self._waiting: list[_Waiting] = []
        self._last: dict[str, deque[tuple[int, NodeCommand]]] = {}
        self._made = self._count = 0
        self._taken = -1
        self._ends: list[tuple[float, Pulses]] = []
        self.begin = machine_pulses(machine, begin)
        self.commands: Iterator[PlacedCommand] = self._commands()

    @property
    def end(self) -> Pulses:
        return machine_pulses(self._machine, self._segments[-1].end)

    def _commands(self) -> Iterator[PlacedCommand]:
        while True:
            while self._made < len(self._segments) and not self._is_ready():
                self._make()
            if not self._waiting:
                return
            taken = heappop(self._waiting)
            self._taken = max(self._taken, taken.segment)
            for last in self._last.values():
                while len(last) > 1 and last[1][0] <= self._taken:
                    last.popleft()
            yield taken.placed

    def _is_ready(self) -> bool:
        """True if no command that is still to be made is needed before the first one that waits."""
        horizon_us = self._stream.at_us - LONGEST_REST_S * 1e6
        return bool(self._waiting) and self._waiting[0].needed_us < horizon_us

    def _make(self) -> None:
        segment = self._segments[self._made]
        before = self._ends[-1][1] if self._ends else self.begin
        there = machine_pulses(self._machine, segment.end)
        pulses = {letter: there[letter] - before[letter] for letter in there}
        for command in self._stream.add(segment.duration_s * 1e6, pulses):
            placed = PlacedCommand(command, self._chords[segment.chord].place)
            heappush(self._waiting, _Waiting(command.needed_us, self._count, self._made, placed))
            self._count += 1
            self._last.setdefault(command.axis, deque()).append((self._made, command))
        self._ends.append((self._stream.at_us, there))
        self._made += 1

    def brake(self) -> bool:
        """Come to rest along the path, behind the last command that was taken. False: it ends about as soon
        by itself."""
        kept = self._taken + 1
        left_s = sum(segment.duration_s for segment in self._segments[kept:])
        if kept == 0 or left_s < WORTH_BRAKING_S or self.is_braked:
            return False
        last = self._segments[kept - 1]
        brake = brake_from(self._planned.stretch, self._planned.speeds, last.chord, last.end, last.at_s)
        self.is_braked, self.rest = True, brake.rest
        offset = len(self._chords)
        self._chords += brake.way.chords
        self._segments[kept:] = [
            each._replace(chord=each.chord + offset)
            for each in segments(brake.way, brake.speeds, self._machine.segment_s, self._machine.axes)
        ]
        self._waiting = [each for each in self._waiting if each.segment < kept]
        heapify(self._waiting)
        self._made = kept
        del self._ends[kept:]
        before = {
            axis: [command for number, command in commands if number < kept]
            for axis, commands in self._last.items()
        }
        self._last = {axis: deque([(kept - 1, made[-1])]) for axis, made in before.items() if made}
        kept_last = {axis: commands[0][1] for axis, commands in self._last.items()}
        self._stream = self._stream.again_from(self._ends[-1][0], kept_last)
        return True

    @property
    def duration_s(self) -> float:
        """Time from the release until all axes stand."""
        return sum(segment.duration_s for segment in self._segments)


def machine_pulses(machine: Machine, position: Sequence[float]) -> dict[str, int]:
    """Pulses from the machine's zero at which a position is."""
    return {axis.letter: axis.pulses_at(place) for axis, place in zip(machine.axes, position, strict=True)}
