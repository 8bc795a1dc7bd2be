"""Distance of a path that was followed from the one that was asked for; and of the zeros of boards, where
set-points are, from those of the shafts, which `hil zero` moves."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from math import dist, sqrt
from typing import Any

from hil.core import KINDS
from hil.gcode.canonical import Arc, Canonical, Point, Straight
from hil.toolpath.machine import Machine
from hil.toolpath.motion_check import ORIGIN, arc_points
from hil.toolpath.path_items import Position

FINE_MM = 0.0005
"""Distance of the drawn path from its arcs."""
BEHIND_MM = 2.0
AHEAD_MM = 4.0
"""Ways behind and before the last place in which the next one is looked for."""


@dataclass(frozen=True)
class Deviation:
    """Largest distance from the path asked for. ``rest``: the way that is left of it at the end; ``course``:
    the way along the path and the distance from it, of each place."""

    largest: float
    at: Position
    rest: float
    course: Sequence[tuple[float, float]] = ()


def asked_path(motions: Iterable[Canonical], machine: Machine, begin: Point = ORIGIN) -> list[Position]:
    """Path that motions ask for, by the positions of the machine's axes, arcs as many points."""
    indices = [axis.index for axis in machine.axes]
    return [tuple(point[index] for index in indices) for point, _ in _asked(motions, begin)]


def asked_rapids(motions: Iterable[Canonical], begin: Point = ORIGIN) -> list[bool]:
    """Find to which points of the path that motions ask for a rapid leads."""
    return [is_rapid for _, is_rapid in _asked(motions, begin)]


def _asked(motions: Iterable[Canonical], begin: Point) -> Iterator[tuple[Point, bool]]:
    here = begin
    yield here, False
    for motion in motions:
        if isinstance(motion, Straight):
            yield motion.end, motion.is_rapid
        elif isinstance(motion, Arc):
            yield from ((point, False) for point in arc_points(here, motion, FINE_MM))
        else:
            continue
        here = motion.end


def deviation(asked: Sequence[Position], followed: Sequence[Position]) -> Deviation:
    """Compare a path with the one asked for, in its order: a place counts with the part of the path around
    the one before."""
    lengths = [dist(a, b) for a, b in pairwise(asked)]
    at, within, largest, where = 0, 0.0, 0.0, followed[0] if followed else ()
    before = followed[0] if followed else ()
    ways = [0.0, *accumulate(lengths)]
    course = []
    for place in followed:
        moved = dist(place, before)
        before = place
        at, within, off = _nearest(asked, lengths, at, within, place, AHEAD_MM + 2 * moved)
        course.append((ways[at] + within, off))
        if off > largest:
            largest, where = off, place
    rest = sum(lengths[at:]) - within if lengths else 0.0
    return Deviation(largest, where, max(rest, 0.0), course)


def _nearest(
    asked: Sequence[Position],
    lengths: Sequence[float],
    at: int,
    within: float,
    place: Position,
    ahead: float,
) -> tuple[int, float, float]:
    """Nearest place of the path around a piece: the piece, the way within it, and the distance."""
    first, back = at, BEHIND_MM - within
    while first > 0 and back > 0:
        first -= 1
        back -= lengths[first]
    best, number, ahead = (at, within, float("inf")), first, ahead + within
    while number < len(lengths) and (number <= at or ahead > 0):
        part, off = _to_piece(asked[number], asked[number + 1], place)
        if off <= best[2] + 1e-9:  # of two parts in one place the later one
            best = number, part * lengths[number], off
        if number >= at:
            ahead -= lengths[number]
        number += 1
    if not lengths:
        return 0, 0.0, dist(asked[0], place)
    return best


def _to_piece(begin: Position, end: Position, place: Position) -> tuple[float, float]:
    """Part of a straight piece at which it is nearest to a place, and the distance."""
    square = dot = 0.0
    for a, b, c in zip(begin, end, place, strict=True):
        square += (b - a) * (b - a)
        dot += (b - a) * (c - a)
    part = min(max(dot / square, 0.0), 1.0) if square > 0 else 0.0
    off = sum((a + part * (b - a) - c) ** 2 for a, b, c in zip(begin, end, place, strict=True))
    return part, sqrt(off)


def board_signal(signals: Mapping[str, Any]) -> str:
    """Signal of an axis that tells where it stands by its board's zero: what a servo's encoder counts, or
    what the board of a stepper has commanded. Empty: the board has no zero of its own."""
    names = (name for kind in KINDS.values() for name in kind.board_angles[:1])
    return next((name for name in names if name in signals), "")


def zero_shift_deg(state: Mapping[str, Any]) -> float:
    """Board's angle less the shaft's, of the state of an axis that stands; 0 for a servo that is off, which
    counts no angle."""
    signal = board_signal(state)
    if not signal or not state.get("loop_on", 1) or state[signal] is None:
        return 0.0
    return float(state[signal] - state["position_deg"])
