"""Constants of the sketch, and what follows from them: the delay between steps and Timer2's counts.

Names, formulas and the lines of boot are the manual's. Arithmetic is that of an AVR, whose ``float`` and
``double`` are IEEE singles.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from hil.firmware.arduino import float32, print_float

TICK_US = 8
"""One count of Timer2: a prescaler of 128 at 16 MHz."""
MOST_COUNTS = 255
"""Counts that OCR2A holds."""


class BadConstant(Exception):
    """Error of a constant that the sketch does not take: ``str(error)`` says why."""


class Limits(NamedTuple):
    """Attribute that has a constant, and what it can be."""

    attribute: str
    low: float
    high: float
    is_whole: bool


CONSTANTS = {
    "microStepping": Limits("microsteps", 1.0, 256.0, True),
    "stepsPerRev": Limits("steps_per_rev", 1.0, 1000.0, True),
    "l": Limits("inductance_mH", 0.001, 10_000.0, False),
    "v": Limits("supply_V", 0.1, 1000.0, False),
    "iMax": Limits("current_A", 0.001, 100.0, False),
    "accelDuring": Limits("accel_steps", 0.0, 255.0, True),
    "stepPin": Limits("step_pin", 2.0, 13.0, True),
    "dirPin": Limits("dir_pin", 2.0, 13.0, True),
    "nVoltes": Limits("turns", 0.0, 1000.0, True),
}
"""Constants by the names that the sketch has for them."""


@dataclass(frozen=True)
class Constants:
    """Constants at the top of the sketch. The usual values are the manual's."""

    microsteps: float = 8.0
    steps_per_rev: float = 200.0
    inductance_mH: float = 50.0
    supply_V: float = 12.0
    current_A: float = 0.135
    accel_steps: float = 10.0
    """Steps in which the speed is reached."""
    step_pin: float = 6.0
    dir_pin: float = 7.0
    turns: float = 1.0
    """Turns of the motor there and back that the sketch makes by itself; 0: it rests."""

    @property
    def delay_us(self) -> int:
        """Least time between steps, rounded down: that in which a coil's current is turned round."""
        us = float32(float32(float32(self.inductance_mH) * 2000.0) * float32(self.current_A))
        return int(float32(float32(us / float32(self.supply_V)) / self.microsteps))

    @property
    def swing_steps(self) -> int:
        """Steps there, and back, that the sketch makes by itself."""
        return int(self.turns * self.steps_per_rev * self.microsteps)

    def with_values(self, values: Mapping[str, float]) -> "Constants":
        """Copy with other values, by the sketch's names.

        Raises:
            BadConstant: there is no such constant, it cannot have the value, or they do not go together.
        """
        for name, value in values.items():
            if name not in CONSTANTS:
                raise BadConstant(f"there is no {name}; constants are {' '.join(CONSTANTS)}")
            _, low, high, is_whole = CONSTANTS[name]
            if not low <= value <= high or (is_whole and value != int(value)):
                raise BadConstant(f"{name} is {'a whole number of ' if is_whole else ''}{low:g} to {high:g}")
        changed = replace(self, **{CONSTANTS[name].attribute: value for name, value in values.items()})
        if changed.step_pin == changed.dir_pin:
            raise BadConstant("stepPin and dirPin are two pins")
        if not 1 <= (delay_us := changed.delay_us) <= MOST_COUNTS * TICK_US:
            raise BadConstant(f"{delay_us} us between steps; Timer2 counts 1 to {MOST_COUNTS * TICK_US} us")
        return changed

    def value(self, name: str) -> float:
        """Value of a constant by the sketch's name."""
        value: float = getattr(self, CONSTANTS[name].attribute)
        return value


def counts_of(delay_us: int) -> int:
    """Counts of Timer2 for a delay, rounded up."""
    return math.ceil(delay_us / TICK_US)


class TimerRamp(NamedTuple):
    """Counts of a move: it begins with ``first``, which each of ``during`` steps makes less by ``delta``."""

    first: int
    delta: int
    during: int


def ramp_of(counts: int, accel_during: int) -> TimerRamp:
    """Ramp to a speed, as the manual's sketch fits it into the 8 bits of OCR2A."""
    if accel_during == 0:
        return TimerRamp(counts, 0, 0)
    delta = (MOST_COUNTS - counts) // accel_during
    if delta > 0:
        return TimerRamp(counts + delta * accel_during, delta, accel_during)
    if counts < MOST_COUNTS:
        return TimerRamp(MOST_COUNTS, 1, MOST_COUNTS - counts)
    return TimerRamp(counts, 0, 0)


def boot_text(of: Constants) -> bytes:
    """Print what the manual's sketch prints at boot, to the byte; its last line has no end."""
    delay_us, during = of.delay_us, int(of.accel_steps)
    counts = counts_of(delay_us)
    lines = [print_float(float(counts))]
    if during > 0:
        lines.append(str((MOST_COUNTS - counts) // during))
    steps = float32(of.steps_per_rev * of.microsteps)
    timed_us = counts * TICK_US
    lines += [
        str(ramp_of(counts, during).first),
        f"Inter Step Delay: {delay_us} us",
        f"Max Speed: {print_float(_rpm(steps, delay_us))} RPM",
        f"Inter Step Delay programat a Timer2: {timed_us}",
        f"Max Speed Real: {print_float(_rpm(steps, timed_us))}",
    ]
    return "\r\n".join(lines).encode()


def _rpm(steps_per_rev: float, delay_us: int) -> float:
    return float32(60000000.0 / float32(steps_per_rev * delay_us))
