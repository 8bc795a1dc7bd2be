"""Parts of a path: stretches of straight pieces, the joining of short ones to longer ones within the path's
tolerance, and what happens between them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from hil.gcode.canonical import Dwell, End, Message, Pause, Switch, TextPlace

Position = tuple[float, ...]
"""Positions of a machine's axes, in the order of ``Machine.axes``: millimetres, degrees."""


class Chord(NamedTuple):
    """Straight piece of a path. Lengths are along the path: millimetres, or degrees if only A B C turn."""

    end: Position
    way: Position
    """From its beginning to its end."""
    length: float
    measure: int
    """Axes that the length is measured over: 0 for X Y Z, 1 for U V W, 2 for A B C."""
    asked_per_s: float
    """Speed that is asked for; infinite: as fast as the axes can."""
    place: TextPlace
    is_arc: bool


@dataclass(frozen=True)
class Stretch:
    """Part of a path between two stops."""

    begin: Position
    chords: Sequence[Chord]
    is_rapid: bool
    tolerance: float
    """Distance from the path that its corners may have; 0: none."""


Item = Stretch | Dwell | Switch | Pause | Message | End

MOST_JOINED = 200
"""Maximum number of pieces that one stands for."""

Length = Callable[[Position], tuple[int, float]]
"""Answers what the length of a way is of, and the length."""


def joined(
    begin: Position, chords: Sequence[Chord], tolerance: float, segment_s: float, length: Length
) -> list[Chord]:
    """Join short pieces of one speed to longer ones that are within the tolerance of them, as long as one
    takes less than ``segment_s``."""
    result: list[Chord] = []
    here, at = begin, 0
    while at < len(chords):
        first = chords[at]
        longest, last, done = first.asked_per_s * segment_s, at, first.length
        while (
            done < longest
            and last + 1 < len(chords)
            and last - at < MOST_JOINED
            and _can_join(first, chords[last + 1])
            and _is_within(here, chords, at, last + 1, tolerance)
        ):
            last += 1
            done += chords[last].length
        if last == at:
            result.append(first)
        elif (whole := _joined(here, chords[at], chords[last].end, length)).length > 0:
            result.append(whole)
        here, at = chords[last].end, last + 1
    return result


def _can_join(first: Chord, other: Chord) -> bool:
    is_alike = other.measure == first.measure and other.asked_per_s == first.asked_per_s
    return is_alike and not first.is_arc and not other.is_arc


def _is_within(here: Position, chords: Sequence[Chord], first: int, last: int, tolerance: float) -> bool:
    """True if all ends of pieces before the last one are near the straight line to its end."""
    way = [b - a for a, b in zip(here, chords[last].end, strict=True)]
    square = sum(each * each for each in way)
    for chord in chords[first:last]:
        off = [b - a for a, b in zip(here, chord.end, strict=True)]
        part = 0.0
        if square > 0:
            part = min(max(sum(a * b for a, b in zip(off, way, strict=True)) / square, 0.0), 1.0)
        if sum((a - part * b) ** 2 for a, b in zip(off, way, strict=True)) > tolerance * tolerance:
            return False
    return True


def _joined(here: Position, first: Chord, end: Position, length: Length) -> Chord:
    way = tuple(b - a for a, b in zip(here, end, strict=True))
    measure, whole = length(way)
    return first._replace(end=end, way=way, length=whole, measure=measure)
