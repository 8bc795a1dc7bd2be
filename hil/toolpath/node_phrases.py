"""Plan of a path as phrases of commands for the nodes of a line, piece by piece as they are needed."""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace

from hil.gcode.canonical import TextPlace
from hil.toolpath.line_load import can_be_sent, line_load
from hil.toolpath.machine import Machine
from hil.toolpath.path_items import Chord, Item, Position, Stretch
from hil.toolpath.path_plan import PathPlan, PlannedStretch, planned
from hil.toolpath.path_speeds import StreamSegment, limits_of
from hil.toolpath.stream_phrase import (
    LONGEST_REST_S,
    PlacedCommand,
    Pulses,
    StreamPhrase,
    machine_pulses,
)
from hil.vocab.path_planning import AxisMotion, PathPlanner

NO_PULSE, TOO_MANY = "no pulse", "too many commands"


@dataclass(frozen=True)
class LinePhrase:
    """Straight line with ramps."""

    commands: Iterator[PlacedCommand]
    ahead: int
    duration_s: float
    begin: Pulses
    end: Pulses
    place: TextPlace

    def brake(self) -> bool:
        """A ramp that has begun is the board's."""
        return False


PathPhrase = LinePhrase | StreamPhrase
"""Commands from a rest to a rest, made as they are taken, in the order in which they are to be sent.

``ahead`` is the number of commands of each axis that are to be at the boards before the release. The axes
stand at ``begin`` before it and at ``end`` after it. ``brake`` comes to rest along the path, behind the last
command that was taken; it answers False where it cannot, or the phrase ends about as soon by itself.
"""


class NodePhrases:
    """Maker of the phrases of a plan, all of whose axes are nodes of a line.

    Raises:
        ValueError: an axis has no node.
    """

    def __init__(self, machine: Machine, planner: PathPlanner, override: float = 1.0) -> None:
        if not machine.has_nodes:
            raise ValueError(f"{machine.name} has axes without a node")
        self._machine, self._planner = machine, planner
        self.override = override
        """Factor on the feeds of all that is planned from now on."""

    def of(self, plan: PathPlan) -> Iterator[PathPhrase | Item]:
        """Phrases of a plan, and what is between them."""
        for item in plan.items:
            if isinstance(item, PlannedStretch):
                yield from self._stretch(item.stretch, item)
            else:
                yield item

    def pulses_at(self, position: Position) -> dict[str, int]:
        """Pulses from the machine's zero at which a position is."""
        return machine_pulses(self._machine, position)

    def _stretch(self, stretch: Stretch | None, plan: PlannedStretch | None) -> Iterator[PathPhrase]:
        """Phrases of a stretch, planned again where the override has changed or a phrase has braked."""
        while stretch is not None:
            if plan is None or plan.override != self.override:
                plan = planned(stretch, self._machine, self.override)
            if plan.is_streamed:
                stretch = yield from self._stream(plan)
            else:
                stretch = yield from self._lines(plan)
            plan = None

    def _lines(self, plan: PlannedStretch) -> Generator[PathPhrase, None, Stretch | None]:
        here, chords = plan.stretch.begin, plan.stretch.chords
        for number, chord in enumerate(chords):
            if plan.override != self.override:
                return replace(plan.stretch, begin=here, chords=chords[number:])
            one = replace(plan.stretch, begin=here, chords=[chord])
            phrase = self._line(here, chord, plan.override)
            if isinstance(phrase, LinePhrase):
                yield phrase
            elif phrase is TOO_MANY:
                streamed = replace(planned(one, self._machine, plan.override), is_streamed=True)
                yield from self._stream(streamed)
            here = chord.end
        return None

    def _line(self, here: Position, chord: Chord, override: float) -> "LinePhrase | str":
        """Make a line with ramps. Else it is less than a pulse, or more commands than the line can carry."""
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
            return NO_PULSE
        phrase = self._planner.line(motions)
        if not can_be_sent(self._machine, phrase.commands):
            return TOO_MANY
        commands = (PlacedCommand(command, chord.place) for command in phrase.commands)
        ahead = self._planner.queue_length - 1
        return LinePhrase(commands, ahead, phrase.duration_us / 1e6, begin, end, chord.place)

    def _stream(self, plan: PlannedStretch) -> Generator[PathPhrase, None, Stretch | None]:
        segments = list(plan.segments(self._machine))
        here = plan.stretch.begin
        for part in _parts(segments, self._moving(here, segments)):
            ahead = line_load(self._machine, here, part).ahead
            phrase = StreamPhrase(self._machine, self._planner, plan, here, part, ahead)
            yield phrase
            if phrase.is_braked:
                return phrase.rest
            here = part[-1].end
        return None

    def _moving(self, here: Position, segments: Sequence[StreamSegment]) -> Iterator[list[str]]:
        before = self.pulses_at(here)
        for segment in segments:
            there = self.pulses_at(segment.end)
            yield [letter for letter in there if there[letter] != before[letter]]
            before = there


def _parts(segments: Sequence[StreamSegment], moving: Iterator[list[str]]) -> Iterator[list[StreamSegment]]:
    """Divide segments before an axis moves that has rested for longer than ``LONGEST_REST_S``."""
    part: list[StreamSegment] = []
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
