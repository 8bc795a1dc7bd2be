"""Lines and circles for the axes of a line's nodes, as a planner gives them."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import cos, pi, sin
from typing import NamedTuple

from device_profiles.sac.board import PROFILE
from hil.testing import Bench
from hil.vocab.path_planning import AxisMotion, NodeCommand, StepperAxis

PATHS = PROFILE.paths
assert PATHS
TAP = "bus0.master"
AXIS = StepperAxis(200, 1, 10)
PULSES_PER_DEG = 400 / 360
AXES = {"x": 4, "y": 5, "z": 6}


class Place(NamedTuple):
    line: int


class Placed(NamedTuple):
    command: NodeCommand
    place: Place


@dataclass
class Phrase:
    commands: Iterator[Placed]
    ahead: int
    duration_s: float
    begin: dict[str, int]
    end: dict[str, int]
    place: Place = field(default=Place(1))

    def brake(self) -> bool:
        return False


def line(begin: dict[str, int], number: int = 1, speed: float = 2000, **moves: int) -> Phrase:
    """Coordinated line from ``begin``, by so many pulses."""
    largest = max(abs(each) for each in moves.values())
    motions = {
        axis: AxisMotion(AXIS, pulses, speed * abs(pulses) / largest, 8000 * abs(pulses) / largest)
        for axis, pulses in moves.items()
    }
    planned = PATHS.line(motions)
    end = {axis: begin[axis] + moves.get(axis, 0) for axis in begin}
    commands = (Placed(command, Place(number)) for command in planned.commands)
    return Phrase(commands, 29, planned.duration_us / 1e6, begin, end, Place(number))


def circle(begin: dict[str, int], radius: int = 800, pieces: int = 80, piece_s: float = 0.05) -> Phrase:
    """Circle of x and y in pieces of constant speed, back to where it began."""
    stream = PATHS.stream({axis: AXIS for axis in "xy"})
    made: list[Placed] = []
    before = (0, 0)
    for piece in range(1, pieces + 1):
        angle = 2 * pi * piece / pieces
        here = (round(radius * (cos(angle) - 1)), round(radius * sin(angle)))
        moves = {axis: now - was for axis, now, was in zip("xy", here, before, strict=True)}
        made += [Placed(each, Place(piece)) for each in stream.add(piece_s * 1e6, moves)]
        before = here
    made.sort(key=lambda each: each.command.needed_us)
    return Phrase(iter(made), 20, pieces * piece_s, begin, dict(begin))


class Braking(Phrase):
    """Phrase that ends behind the last command that was taken."""

    def __init__(self, of: Phrase) -> None:
        vars(self).update(vars(of))
        self._left = list(of.commands)
        self.commands = self._taken()
        self._done = {axis: [0.0, 0] for axis in of.begin}

    def _taken(self) -> Iterator[Placed]:
        while self._left:
            placed = self._left.pop(0)
            done = self._done[placed.command.axis]
            done[0], done[1] = placed.command.end_us, done[1] + placed.command.pulses
            yield placed

    def brake(self) -> bool:
        self._left.clear()
        self.duration_s = max(end_us for end_us, _ in self._done.values()) / 1e6
        self.end = {axis: self.begin[axis] + int(pulses) for axis, (_, pulses) in self._done.items()}
        return True


def pulses(bench: Bench) -> dict[str, int]:
    """Places of the axes."""
    return {
        axis: round(bench.axis(f"s{node}").snapshot().commanded_deg * PULSES_PER_DEG)
        for axis, node in AXES.items()
    }


def at_zero() -> dict[str, int]:
    return dict.fromkeys(AXES, 0)
