"""Speeds along a stretch: as fast as is asked for, within the axes' limits.

From one chord to the next each axis's speed may change by its acceleration times the duration of a segment
(``segment_ms``): that is what streams of segments of constant speed change by anyway. Along a chord the
speed is a trapezoid. A chord of a longer stretch takes at least a segment.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, inf, sqrt
from typing import NamedTuple

from hil.toolpath.machine import MachineAxis
from hil.toolpath.path_items import Chord, Stretch

CRUISE_SEGMENTS = 4
"""Number of segments for which one of constant speed may last, at most."""
ROUNDING_S = 0.5e-6
"""Largest rounding of a step's period. Source: SAC user manual, cycle."""
LARGEST_DRIFT_STEPS = 0.25
"""Steps that an axis may be away from its place at the end of a long segment, by rounding."""


class ChordSpeed(NamedTuple):
    """Course along a chord: up from a speed to ``most``, and down to another, in seconds and its lengths."""

    length: float
    begin_per_s: float
    most_per_s: float
    end_per_s: float
    acceleration_per_s2: float

    @property
    def up_s(self) -> float:
        return (self.most_per_s - self.begin_per_s) / self.acceleration_per_s2

    @property
    def down_s(self) -> float:
        return (self.most_per_s - self.end_per_s) / self.acceleration_per_s2

    @property
    def cruise_s(self) -> float:
        ramps = self.up_s * (self.begin_per_s + self.most_per_s) + self.down_s * (
            self.end_per_s + self.most_per_s
        )
        return max((self.length - ramps / 2) / self.most_per_s, 0.0)

    @property
    def duration_s(self) -> float:
        return self.up_s + self.cruise_s + self.down_s

    def part_at(self, at_s: float) -> float:
        """Part of the chord that is done at a time, 0 to 1."""
        up_s, a = self.up_s, self.acceleration_per_s2
        if at_s <= up_s:
            done = at_s * (self.begin_per_s + a * at_s / 2)
        elif (left_s := self.duration_s - at_s) <= self.down_s:
            done = self.length - max(left_s, 0.0) * (self.end_per_s + a * max(left_s, 0.0) / 2)
        else:
            done = up_s * (self.begin_per_s + self.most_per_s) / 2 + (at_s - up_s) * self.most_per_s
        return min(max(done / self.length, 0.0), 1.0)

    def looks_s(self, segment_s: float, cruise_segments: int = CRUISE_SEGMENTS) -> list[float]:
        """Times at which segments end: none much shorter than ``segment_s`` where the chord is longer."""
        up_s, cruise_s, down_s = self.up_s, self.cruise_s, self.down_s
        ends, at_s = [], 0.0
        for lasts_s, longest_s in (
            (up_s, segment_s),
            (cruise_s, cruise_segments * segment_s),
            (down_s, segment_s),
        ):
            count = ceil(lasts_s / longest_s - 1e-9)
            ends += [at_s + lasts_s * (number + 1) / count for number in range(count)]
            at_s += lasts_s
        kept: list[float] = []
        for end_s in ends:
            if end_s - (kept[-1] if kept else 0.0) >= segment_s * 0.6:
                kept.append(end_s)
        if kept and at_s - kept[-1] < segment_s * 0.6:
            kept.pop()
        return [*kept, at_s]


@dataclass(frozen=True)
class ChordLimits:
    """Limits of the axes along a chord, and the axis that sets the speed's."""

    speed_per_s: float
    acceleration_per_s2: float
    slowest: MachineAxis


def limits_of(chord: Chord, axes: Sequence[MachineAxis]) -> ChordLimits:
    """Limits of the axes along a chord, in its own lengths."""
    speed = acceleration = inf
    slowest = axes[0]
    for axis, way in zip(axes, chord.way, strict=True):
        if way:
            ratio = chord.length / abs(way)
            if axis.speed_per_s * ratio < speed:
                speed, slowest = axis.speed_per_s * ratio, axis
            acceleration = min(acceleration, axis.acceleration_per_s2 * ratio)
    return ChordLimits(speed, acceleration, slowest)


def corner_per_s(chord: Chord, other: Chord, axes: Sequence[MachineAxis], segment_s: float) -> float:
    """Speed at which the machine may go from one chord into the other."""
    if chord.measure != other.measure:
        return 0.0
    most = inf
    for axis, way, next_way in zip(axes, chord.way, other.way, strict=True):
        change = abs(next_way / other.length - way / chord.length)
        if change > 1e-12:
            most = min(most, axis.acceleration_per_s2 * segment_s / change)
    return most


def stretch_speeds(
    stretch: Stretch, axes: Sequence[MachineAxis], segment_s: float, override: float = 1.0
) -> list[ChordSpeed]:
    """Plan the speeds of a stretch from rest to rest; ``override`` is a factor on what is asked for."""
    chords = stretch.chords
    limits = [limits_of(chord, axes) for chord in chords]
    shortest_s = segment_s if len(chords) > 1 else 0.0
    most = []
    for chord, limit in zip(chords, limits, strict=True):
        speed = min(chord.asked_per_s * override, limit.speed_per_s)
        most.append(min(speed, chord.length / shortest_s) if shortest_s else speed)
    joints = [0.0] * (len(chords) + 1)
    for number in range(len(chords) - 1, 0, -1):
        corner = corner_per_s(chords[number - 1], chords[number], axes, segment_s)
        back = sqrt(joints[number + 1] ** 2 + 2 * limits[number].acceleration_per_s2 * chords[number].length)
        joints[number] = min(corner, most[number - 1], most[number], back)
    speeds = []
    for number, (chord, limit) in enumerate(zip(chords, limits, strict=True)):
        begin, twice = joints[number], 2 * limit.acceleration_per_s2 * chord.length
        end = joints[number + 1] = min(joints[number + 1], sqrt(begin * begin + twice))
        peak = sqrt((twice + begin * begin + end * end) / 2)
        speeds.append(
            ChordSpeed(
                chord.length, begin, max(min(most[number], peak), begin, end), end, limit.acceleration_per_s2
            )
        )
    return speeds


def stops_s(stretch: Stretch, axes: Sequence[MachineAxis], override: float = 1.0) -> float:
    """Time of a stretch if the machine stops at the end of each chord."""
    total_s = 0.0
    for chord in stretch.chords:
        limit = limits_of(chord, axes)
        speed = min(
            chord.asked_per_s * override, limit.speed_per_s, sqrt(limit.acceleration_per_s2 * chord.length)
        )
        total_s += chord.length / speed + speed / limit.acceleration_per_s2
    return total_s


class StreamSegment(NamedTuple):
    """Segment of constant speed of a stream, and the chord that it is of."""

    duration_s: float
    end: tuple[float, ...]
    chord: int
    at_s: float
    """Time of its end from the chord's beginning."""


def cruise_segments(chord: Chord, speed: ChordSpeed, axes: Sequence[MachineAxis], segment_s: float) -> int:
    """Number of segments for which one of constant speed may last: as long as periods of whole microseconds
    keep an axis within ``LARGEST_DRIFT_STEPS``."""
    most_s = inf
    for axis, way in zip(axes, chord.way, strict=True):
        steps = abs(way * axis.pulses_per_unit) / axis.stepper.pulses_per_step
        if steps:
            steps_per_s = steps / chord.length * speed.most_per_s
            most_s = min(most_s, LARGEST_DRIFT_STEPS / (ROUNDING_S * steps_per_s**2))
    return max(min(CRUISE_SEGMENTS, int(min(most_s / segment_s, CRUISE_SEGMENTS))), 1)


def segments(
    stretch: Stretch, speeds: Sequence[ChordSpeed], segment_s: float, axes: Sequence[MachineAxis]
) -> Iterator[StreamSegment]:
    """Segments of a stretch, one after the other; none goes beyond the end of a chord."""
    here = stretch.begin
    for number, (chord, speed) in enumerate(zip(stretch.chords, speeds, strict=True)):
        before_s = 0.0
        looks_s = speed.looks_s(segment_s, cruise_segments(chord, speed, axes, segment_s))
        for at_s in looks_s[:-1]:
            part = speed.part_at(at_s)
            place = tuple(a + part * b for a, b in zip(here, chord.way, strict=True))
            yield StreamSegment(at_s - before_s, place, number, at_s)
            before_s = at_s
        yield StreamSegment(looks_s[-1] - before_s, chord.end, number, looks_s[-1])
        here = chord.end
