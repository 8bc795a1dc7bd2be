"""Commands of one SAC of a phrase, each beginning exactly where the one before ended."""

from collections.abc import Callable
from math import ceil

from device_profiles.sac.pulse_times import (
    LOAD_US,
    MOST_CYCLE_US,
    cruise_half_us,
    ramp_rpm,
    ramp_us,
)
from device_profiles.sac.typed_text import MIN_CYCLE_US
from hil.vocab.path_planning import NodeCommand, StepperAxis

LARGEST_ERROR_STEPS = (0.05, 0.2)
"""Error of a piece of constant speed at which a new one begins: where a pulse is a full step, and where it is
less, which leaves more of a step to errors."""


def largest_error_steps(axis: StepperAxis) -> float:
    return LARGEST_ERROR_STEPS[axis.microstep_exponent > 0]


class AxisCommands:
    """Commands that an axis gets one after the other, and where they leave it. Attributes that the board
    keeps from the command before are left out."""

    def __init__(self, name: str, axis: StepperAxis) -> None:
        self.axis = axis
        self.commands: list[NodeCommand] = []
        self.at_half_us = 0
        """Time from the release to the earliest next pulse."""
        self._name = name
        self._wait_us = 0
        self._kept: dict[str, str] = {}

    def go_on_after(self, command: NodeCommand) -> None:
        """Go on behind a command of another plan. What the board keeps from it is said again."""
        self.commands = [command]
        self.at_half_us = round(2 * command.end_us)

    def rest_until(self, at_us: float) -> None:
        """Let the next command begin then, or where the last one ended if no wait is so short."""
        if not self.commands:
            self._wait_us = max(round(at_us), 0)
            self.at_half_us = 2 * self._wait_us
            return
        wait_us = round(at_us - self.commands[-1].end_us) - LOAD_US
        if wait_us > 0:
            self._wait_us = wait_us
            self.at_half_us = round(2 * self.commands[-1].end_us) + 2 * (LOAD_US + wait_us)

    def ramp_up(self, steps: int, acc_hundredths: int, is_ccw: bool) -> None:
        """Speed up from rest over so many full steps, along the linear ramp of this acceleration."""
        self._ramp(steps, acc_hundredths, is_ccw, {"a": _acceleration(acc_hundredths), "d": "999"})

    def ramp_down(self, steps: int, dec_hundredths: int, is_ccw: bool) -> None:
        """Slow down to rest over so many full steps."""
        self._ramp(steps, dec_hundredths, is_ccw, {"a": "999", "d": _acceleration(dec_hundredths)})

    def constant(self, pulses: int, end_us: float) -> None:
        """Make signed pulses at one speed, such that the next one would be at this time."""
        pulses_abs = abs(pulses)
        cycle_us = self.cycle_us(pulses_abs, end_us)
        duration = cruise_half_us(self.axis, cycle_us, pulses_abs)
        said = {"v": f"c{cycle_us}", "a": "999", "d": "999"}
        self._add(pulses_abs, pulses < 0, said, duration)

    def cycle_us(self, pulses: int, end_us: float) -> int:
        """Whole period of a full step with which so many pulses end nearest to a time."""
        exact = (end_us - self.at_half_us / 2) * self.axis.pulses_per_step / pulses
        least = max(MIN_CYCLE_US << self.axis.microstep_exponent, 1)
        return min(max(round(exact), least), MOST_CYCLE_US)

    def follow(self, first: int, end: int, us_of: Callable[[float], float], is_ccw: bool) -> None:
        """Make the pulses from one number to the one before another in pieces of constant speed, each pulse
        within ``largest_error_steps`` of the time that ``us_of`` gives for its number."""
        pulse, count = first, end - first
        while pulse < end:
            count = min(max(2 * count, 1), end - pulse)
            while count > 1 and not self._is_near(pulse, count, us_of):
                count = max(count * 2 // 3, 1)
            self.constant(-count if is_ccw else count, us_of(pulse + count))
            pulse += count

    def _is_near(self, pulse: int, count: int, us_of: Callable[[float], float]) -> bool:
        cycle_us = self.cycle_us(count, us_of(pulse + count))
        begin_us, each_us = self.at_half_us / 2, cycle_us / self.axis.pulses_per_step
        allowed_us = largest_error_steps(self.axis) * cycle_us
        places = {count, count - 1, count // 2, ceil(count / 4), 3 * count // 4, 1}
        return all(abs(begin_us + place * each_us - us_of(pulse + place)) <= allowed_us for place in places)

    def _ramp(self, steps: int, hundredths: int, is_ccw: bool, said: dict[str, str]) -> None:
        rpm = ramp_rpm(self.axis, hundredths, steps)
        duration = 2 * sum(ramp_us(self.axis.steps_per_rev, hundredths, steps))
        pulses = steps << self.axis.microstep_exponent
        self._add(pulses, is_ccw, {"v": str(rpm), **said}, duration)

    def _add(self, pulses: int, is_ccw: bool, said: dict[str, str], duration_half_us: int) -> None:
        before = self.commands[-1] if self.commands else None
        text = f"m{'-' if is_ccw else ''}{pulses}"
        said = {"l": "1", **said} if before is None else said
        changed = {letter: value for letter, value in said.items() if self._kept.get(letter) != value}
        self._kept |= changed
        text += "".join(letter + value for letter, value in changed.items())
        if before is None:
            text += "u0ps"
        if self._wait_us:
            text += f"t{self._wait_us}"
        self._wait_us = 0
        start, self.at_half_us = self.at_half_us, self.at_half_us + duration_half_us
        made = -pulses if is_ccw else pulses
        needed_us = before.end_us if before else 0.0
        self.commands.append(
            NodeCommand(self._name, text.encode(), made, start / 2, self.at_half_us / 2, needed_us)
        )


def _acceleration(hundredths: int) -> str:
    whole, decimals = divmod(hundredths, 100)
    return f"{whole}.{decimals:02d}".rstrip("0").rstrip(".")
