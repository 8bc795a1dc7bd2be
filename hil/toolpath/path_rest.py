"""Braking along a path: from a place of a stretch to rest, and what is left of the stretch."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt

from hil.toolpath.path_items import Chord, Position, Stretch
from hil.toolpath.path_speeds import ChordSpeed

TINY = 1e-9
"""Length under which a piece is none, and speed under which a machine rests."""


@dataclass(frozen=True)
class Brake:
    """Way to rest with its speeds, and the rest of the stretch; None: nothing is left of it."""

    way: Stretch
    speeds: Sequence[ChordSpeed]
    rest: Stretch | None


def brake_from(
    stretch: Stretch, speeds: Sequence[ChordSpeed], number: int, here: Position, at_s: float
) -> Brake:
    """Brake as soon as the accelerations allow, without leaving the path: from a place of a chord, at a time
    from its beginning."""
    chords = [_from_place(stretch.chords[number], here), *stretch.chords[number + 1 :]]
    speed = _speed_at(speeds[number], at_s)
    way: list[Chord] = []
    courses: list[ChordSpeed] = []
    for index, chord in enumerate(chords):
        if chord.length <= TINY:
            continue
        if speed <= TINY:
            return Brake(_part(stretch, here, way), courses, _part(stretch, _end(here, way), chords[index:]))
        course = speeds[number + index]
        acceleration = course.acceleration_per_s2
        needed = speed * speed / (2 * acceleration)
        if needed < chord.length - TINY:
            first, second = _cut(_end(here, way), chord, needed / chord.length)
            way.append(first)
            courses.append(ChordSpeed(first.length, speed, speed, 0.0, acceleration))
            rest = [second, *chords[index + 1 :]]
            return Brake(_part(stretch, here, way), courses, _part(stretch, first.end, rest))
        end = min(sqrt(max(speed * speed - 2 * acceleration * chord.length, 0.0)), course.end_per_s)
        way.append(chord)
        # Where the plan itself brakes more, at the end, that is what is needed.
        courses.append(ChordSpeed(chord.length, speed, speed, end, _needed(speed, end, chord.length)))
        speed = end
    return Brake(_part(stretch, here, way), courses, None)


def _needed(begin_per_s: float, end_per_s: float, length: float) -> float:
    return max((begin_per_s**2 - end_per_s**2) / (2 * length), TINY)


def _speed_at(course: ChordSpeed, at_s: float) -> float:
    up = course.begin_per_s + course.acceleration_per_s2 * at_s
    down = course.end_per_s + course.acceleration_per_s2 * max(course.duration_s - at_s, 0.0)
    return min(up, course.most_per_s, down)


def _part(stretch: Stretch, begin: Position, chords: Sequence[Chord]) -> Stretch:
    return replace(stretch, begin=begin, chords=list(chords))


def _end(begin: Position, chords: Sequence[Chord]) -> Position:
    return chords[-1].end if chords else begin


def _from_place(chord: Chord, here: Position) -> Chord:
    way = tuple(b - a for a, b in zip(here, chord.end, strict=True))
    whole = sum(abs(each) for each in chord.way)
    part = sum(abs(each) for each in way) / whole if whole else 0.0
    return chord._replace(way=way, length=chord.length * part)


def _cut(here: Position, chord: Chord, part: float) -> tuple[Chord, Chord]:
    end = tuple(a + part * b for a, b in zip(here, chord.way, strict=True))
    first = chord._replace(end=end, way=tuple(part * each for each in chord.way), length=chord.length * part)
    return first, _from_place(chord, end)
