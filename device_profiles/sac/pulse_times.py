"""Times of the pulses that a SAC's motion command makes, as its engine computes them.

Half-microseconds, the resolution of the board's timer. Source: SAC user manual, linear ramps and microsteps;
``README.md``, decisions.
"""

from functools import lru_cache
from math import pi, sqrt

from device_profiles.sac.typed_text import NO_RAMP, WORD
from hil.vocab.path_planning import StepperAxis

LOAD_US = 16
"""Time to load a command that is no seamless continuation."""
START_CORRECTION = 0.676
"""Factor of the first period of a linear ramp, with which its later ones agree with the formula (Austin)."""
LEAST_ACCELERATION, WHOLE_FROM, MOST_ACCELERATION = 1, 100_00, NO_RAMP - 100
"""Accelerations in hundredths of rad/s2: two decimals below ``WHOLE_FROM``, whole numbers from there on."""
MOST_CYCLE_US = WORD - 1


def radians_per_s2(axis: StepperAxis, steps_per_s2: float) -> float:
    """Acceleration as the board takes it, of one in full steps."""
    return 2 * pi / axis.steps_per_rev * steps_per_s2


def hundredths_of(radians_per_s2: float) -> int:
    """Nearest acceleration that the board can hold, in hundredths."""
    hundredths = round(radians_per_s2 * 100)
    if hundredths >= WHOLE_FROM:
        hundredths = round(radians_per_s2) * 100
    return min(max(hundredths, LEAST_ACCELERATION), MOST_ACCELERATION)


@lru_cache(maxsize=64)
def ramp_us(steps_per_rev: int, acc_hundredths: int, steps: int) -> tuple[int, ...]:
    """Periods in microseconds of the full steps of a linear ramp from rest; to rest they are backwards."""
    alpha = 2 * pi / steps_per_rev
    c = START_CORRECTION * 1_000_000 * sqrt(2 * alpha / (acc_hundredths / 100))
    periods = []
    for n in range(1, steps + 1):
        periods.append(int(c))
        c -= 2 * c / (4 * n + 1)
    return tuple(periods)


def ramp_rpm(axis: StepperAxis, acc_hundredths: int, steps: int) -> int:
    """Least speed to command, in whole RPM, such that a linear ramp is at least so many steps long."""
    acceleration = acc_hundredths / 100
    rpm = int(sqrt(2 * (2 * pi / axis.steps_per_rev) * acceleration * steps) * 60 / (2 * pi))
    return max(rpm + 1, axis.slow_rpm + 1)


def cruise_half_us(axis: StepperAxis, cycle_us: int, pulses: int) -> int:
    """Duration of so many pulses, counted from the beginning of a full step."""
    return (2 * cycle_us * pulses) >> axis.microstep_exponent
