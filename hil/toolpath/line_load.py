"""Load of a line of SACs by a stream: whether every command can be at its board in time."""

from collections.abc import Sequence
from dataclasses import dataclass

from hil.toolpath.machine import Machine
from hil.toolpath.path_speeds import StreamSegment
from hil.vocab.path_planning import NodeCommand

WAITING = 28
"""Commands that may wait at a board: it has room for 30, one of which runs; one is in reserve."""
COMMAND_CHARACTERS = 29
"""Characters of a command of a stream on the line, ``m-1234vc12345``: a packet of 19, a turnaround of two,
an answer of 7, and one in reserve. Source: SAC user manual, communications."""
BITS_OF_CHARACTER = 10
COMFORT_S = 0.6
"""Time that commands are early with which nothing more has to be at the boards before the start: programs on
a busy computer are that late."""
WINDOW_S = 1.0
"""Time in which commands are counted."""


@dataclass(frozen=True)
class LineLoad:
    """Load of a line. ``margin_s`` is the least time that a command is early; below 0 it would be late."""

    needed_per_s: float
    possible_per_s: float
    ahead: int
    """Number of segments that are to be at the boards before the start."""
    margin_s: float

    @property
    def keeps_up(self) -> bool:
        return self.margin_s >= 0


def command_s(machine: Machine) -> float:
    """Time that a command takes, with its answer and the latency of the way to the line."""
    return COMMAND_CHARACTERS * BITS_OF_CHARACTER / machine.text.baud + machine.text.latency_ms / 1000


def line_load(machine: Machine, begin: tuple[float, ...], segments: Sequence[StreamSegment]) -> LineLoad:
    """Calculate the load by a stretch that begins there."""
    each_s = command_s(machine)
    counts, starts_s = _commands(machine, begin, segments)
    margin_s, ahead = float("-inf"), 0
    for ahead in sorted({min(count, len(counts)) for count in (4, 8, 16, WAITING)}):
        margin_s = _margin_s(counts, starts_s, ahead, each_s)
        if margin_s >= COMFORT_S:
            break
    return LineLoad(_busiest_per_s(counts, starts_s), 1 / each_s, ahead, margin_s)


def can_be_sent(machine: Machine, commands: Sequence[NodeCommand]) -> bool:
    """True if each command of a line with ramps can be at its board in time; as many as there is room for
    are there before the start."""
    each_us, sent_us = command_s(machine) * 1e6, 0.0
    starts_us: dict[str, list[float]] = {}
    for command in commands:
        before = starts_us.setdefault(command.axis, [])
        if len(before) >= WAITING:
            sent_us = max(sent_us, before[-WAITING]) + each_us
            if sent_us > command.needed_us:
                return False
        before.append(command.start_us)
    return True


def _commands(
    machine: Machine, begin: tuple[float, ...], segments: Sequence[StreamSegment]
) -> tuple[list[int], list[float]]:
    """Number of commands of each segment, and the times at which the segments begin."""
    counts, starts_s, at_s = [], [], 0.0
    here = [axis.pulses_at(place) for axis, place in zip(machine.axes, begin, strict=True)]
    for segment in segments:
        there = [axis.pulses_at(place) for axis, place in zip(machine.axes, segment.end, strict=True)]
        counts.append(sum(a != b for a, b in zip(here, there, strict=True)))
        starts_s.append(at_s)
        here, at_s = there, at_s + segment.duration_s
    return counts, starts_s


def _margin_s(counts: Sequence[int], starts_s: Sequence[float], ahead: int, each_s: float) -> float:
    """Least time that commands are early, if the first segments are at the boards at the start."""
    sent_s, margin_s = 0.0, float("inf")
    for number in range(ahead, len(counts)):
        room_s = starts_s[number - WAITING] if number >= WAITING else 0.0
        sent_s = max(sent_s, room_s) + counts[number] * each_s
        # A board needs its next command when the one before ends: that is when this segment begins.
        margin_s = min(margin_s, starts_s[number] - sent_s)
    return margin_s if ahead < len(counts) else float("inf")


def _busiest_per_s(counts: Sequence[int], starts_s: Sequence[float]) -> float:
    """Largest number of commands that begin within a second."""
    first, total, most = 0, 0, 0
    for count, start_s in zip(counts, starts_s, strict=True):
        total += count
        while starts_s[first] <= start_s - WINDOW_S:
            total -= counts[first]
            first += 1
        most = max(most, total)
    return most / WINDOW_S
