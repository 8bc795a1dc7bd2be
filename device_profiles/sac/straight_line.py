"""Straight lines that several SACs keep to together, from rest to rest.

All axes share one course: the part of the way that is done, a trapezoid in time. Where an axis's ramp of
whole steps and rounded acceleration keeps to that course, it is the board's own linear ramp, with a start
wait that lets the cruise begin where the course has it; that cures what the first period (``ramp_us``)
leaves, too. Where it does not, and in the cruise, whose period is whole microseconds, the axis follows in
pieces of constant speed.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import ceil, sqrt

from device_profiles.sac.axis_commands import AxisCommands, largest_error_steps
from device_profiles.sac.pulse_times import (
    MOST_ACCELERATION,
    WHOLE_FROM,
    hundredths_of,
    radians_per_s2,
    ramp_us,
)
from hil.vocab.path_planning import AxisMotion, NodeCommand

CANDIDATES = 40
"""Number of accelerations that are tried for the axis with the largest one, each a hundredth less."""
LEAST_SHARE = 0.9
"""Least share of the acceleration that is allowed with which the others may fit better."""
LEAST_SPEED_SHARE = 0.98
"""Least share of the speed with which the periods may be nearer to whole microseconds."""
FEW = 6.0
"""Number of pieces of all axes that needs no slower course."""
FITS_STEPS = 0.05
"""Error by rounded accelerations that needs no better ones."""
EARLIEST_STEPS, LATEST_STEPS = 0.15, 0.6
"""Steps that a pulse of a ramp may come before and after the course has it."""
LOOKS = 24
"""Number of steps of a ramp that are compared with the course."""


@dataclass(frozen=True)
class Course:
    """Part of the way that is done, from 0 to 1, as a trapezoid in seconds."""

    speed_per_s: float
    acceleration_per_s2: float

    @property
    def duration_s(self) -> float:
        return 1 / self.speed_per_s + self.speed_per_s / self.acceleration_per_s2

    @property
    def ramp_part(self) -> float:
        """Part of the way over which the speed rises."""
        return self.speed_per_s**2 / (2 * self.acceleration_per_s2)

    def us_at(self, part: float) -> float:
        """Time at which a part is done."""
        if part >= 1:
            return self.duration_s * 1e6
        if part > 0.5:
            return (self.duration_s - self._s_at(1 - part)) * 1e6
        return self._s_at(part) * 1e6

    def _s_at(self, part: float) -> float:
        if part <= self.ramp_part:
            return sqrt(2 * max(part, 0.0) / self.acceleration_per_s2)
        return part / self.speed_per_s + self.speed_per_s / (2 * self.acceleration_per_s2)


class LineAxis:
    """Share of an axis in a line."""

    def __init__(self, name: str, move: AxisMotion) -> None:
        self.name, self.move = name, move
        self.pulses = abs(move.pulses)
        self.steps = self.pulses / move.axis.pulses_per_step
        self.commands = AxisCommands(name, move.axis)

    def radians_per_s2(self, course: Course) -> float:
        return radians_per_s2(self.move.axis, self.steps * course.acceleration_per_s2)

    def rounding_steps(self, course: Course) -> float:
        """Steps by which the rounded acceleration leaves the course at most, about."""
        exact = self.radians_per_s2(course)
        error = abs(hundredths_of(exact) / 100 - exact) / exact
        return error * course.ramp_part * self.steps / 4

    def pieces(self, course: Course) -> float:
        """Number of pieces of constant speed for the whole way, about: each has a period of whole us."""
        period_us = 1e6 / (self.steps * course.speed_per_s)
        part = period_us % 1
        return self.steps * 2 * part * (1 - part) / (largest_error_steps(self.move.axis) * period_us)

    def ramp(self, course: Course) -> tuple[int, int]:
        """Number of steps and acceleration of the ramp; no step where none keeps to the course."""
        steps = int(course.ramp_part * self.steps)
        exact = self.radians_per_s2(course)
        hundredths = hundredths_of(exact)
        if (
            not steps
            or exact * 100 > MOST_ACCELERATION + WHOLE_FROM
            or not self._keeps(course, steps, hundredths)
        ):
            return 0, hundredths
        return steps, hundredths

    def _keeps(self, course: Course, steps: int, hundredths: int) -> bool:
        periods = ramp_us(self.move.axis.steps_per_rev, hundredths, steps)
        at_us = self.start_us(course, steps, hundredths)
        every = max(steps // LOOKS, 1)
        for step, period_us in enumerate(periods):
            if step % every == 0:
                part = step / self.steps
                if step and at_us < course.us_at(max(step - EARLIEST_STEPS, 0.0) / self.steps):
                    return False
                if at_us > course.us_at(part + LATEST_STEPS / self.steps):
                    return False
            at_us += period_us
        return True

    def us_of(self, course: Course, pulse: float) -> float:
        """Time at which a pulse comes: half a period of the cruise after the course has what was made before
        it, so that in the cruise the course is in the middle of the pulse."""
        return course.us_at(pulse / self.pulses) + 0.5e6 / (self.pulses * course.speed_per_s)

    def start_us(self, course: Course, steps: int, hundredths: int) -> float:
        """Time of the first pulse with which the cruise begins when the course has it."""
        ramp = sum(ramp_us(self.move.axis.steps_per_rev, hundredths, steps))
        return self.us_of(course, steps * self.move.axis.pulses_per_step) - ramp

    def write(self, course: Course, ramp: tuple[int, int], shift_us: float) -> None:
        """Write the commands, all ``shift_us`` later than the course."""
        steps, hundredths = ramp
        is_ccw = self.move.pulses < 0
        first = steps * self.move.axis.pulses_per_step
        self.commands.rest_until(self.start_us(course, *ramp) + shift_us)
        if steps:
            self.commands.ramp_up(steps, hundredths, is_ccw)
        self.commands.follow(
            first, self.pulses - first, lambda pulse: self.us_of(course, pulse) + shift_us, is_ccw
        )
        if steps:
            self.commands.ramp_down(steps, hundredths, is_ccw)


def plan_line(moves: Mapping[str, AxisMotion]) -> list[NodeCommand]:
    """Plan the commands of a line. Raises ValueError: a move has no pulses, speed or acceleration."""
    for name, move in moves.items():
        if not move.pulses or not move.speed_per_s > 0 or not move.acceleration_per_s2 > 0:
            raise ValueError(f"{name}: a line needs pulses, a speed and an acceleration")
    axes = [LineAxis(name, move) for name, move in moves.items()]
    course = even_course(axes, fitting_course(axes))
    ramps = [axis.ramp(course) for axis in axes]
    shift_us = -min(axis.start_us(course, *ramp) for axis, ramp in zip(axes, ramps, strict=True))
    for axis, ramp in zip(axes, ramps, strict=True):
        axis.write(course, ramp, shift_us)
    commands = [command for axis in axes for command in axis.commands.commands]
    return sorted(commands, key=lambda command: command.needed_us)


def fitting_course(axes: list[LineAxis]) -> Course:
    """Choose the quickest course within the limits, or one that is a little slower in its ramps, with which
    the rounded accelerations of all axes keep to it."""
    courses = list(_courses(axes))
    best = courses[0]
    least = float("inf")
    for course in courses:
        worst = max(axis.rounding_steps(course) for axis in axes)
        if worst < least:
            best, least = course, worst
        if worst <= FITS_STEPS:
            break
    return best


def even_course(axes: list[LineAxis], course: Course) -> Course:
    """Choose a course that is a little slower, where the periods of its axes are nearer to whole microseconds
    and its cruise needs fewer pieces."""
    first = max(axes, key=lambda axis: axis.steps)
    period_us = 1e6 / (first.steps * course.speed_per_s)
    courses = [course]
    for whole_us in range(ceil(period_us), ceil(period_us / LEAST_SPEED_SHARE) + 2):
        courses.append(replace(course, speed_per_s=min(1e6 / (first.steps * whole_us), course.speed_per_s)))
    return min(courses[: CANDIDATES + 1], key=lambda each: max(sum(axis.pieces(each) for axis in axes), FEW))


def _courses(axes: list[LineAxis]) -> Iterator[Course]:
    speed = min(axis.move.speed_per_s / axis.pulses for axis in axes)
    most = min(axis.move.acceleration_per_s2 / axis.pulses for axis in axes)
    first = max(axes, key=lambda axis: axis.radians_per_s2(Course(1.0, 1.0)))
    exact = first.radians_per_s2(Course(speed, most)) * 100
    each = 100 if exact >= WHOLE_FROM else 1
    least = max(int(exact * LEAST_SHARE) - each, 0)
    rounded = range(int(exact / each) * each, least, -each)[:CANDIDATES]
    for acceleration in [most * hundredths / exact for hundredths in rounded] or [most]:
        yield Course(min(speed, sqrt(acceleration)), acceleration)
