"""The board's clock, and its main loop, which the core runs: passes, pulses, drive laws.

The firmware takes a pass for itself where it has something to do in it, and gives the rest of it back. While
it waits with ``hold``, pulses go on; with ``pause``, nothing does.
"""

from collections.abc import Generator
from typing import Any

from hil.vocab.firmware import ArmJoint, Delay, Request
from hil.vocab.time import NS_PER_MS

NS_PER_US = 1000
US_PER_MS = 1000
Steps = Generator[Request, Any, None]
"""Part of the main program that takes time."""


class BoardLoop:
    """Main loop of the board. ``first``: the joint that holds it in the core."""

    def __init__(self, first: ArmJoint) -> None:
        self._do = first.do

    def start(self) -> None:
        """Begin with the clock at 0. Raises TypeError: the joints are not those of an arm."""
        if self._do("start") < 0:
            raise TypeError("Walter's Cortex needs five joints, one after the other")

    @property
    def us(self) -> int:
        """Microseconds since power-up."""
        return int(self._do("clock"))

    @property
    def ms(self) -> int:
        """Whole milliseconds since power-up."""
        return int(self._do("clock")) // US_PER_MS

    def knows_joints(self, knows: bool) -> None:
        """Let pulses and drive laws be made, or not."""
        self._do("know", float(knows))

    def power(self, is_on: bool) -> None:
        """Switch the motors' 24 V."""
        self._do("power", float(is_on))

    def take_pass(self) -> Generator[Request, Any, tuple[int, int]]:
        """Wait for the next pass and take it; answers the ms that the pass before it went by, and the ms in
        which it began. It is taken a nanosecond late: what comes just as it begins belongs to it."""
        at_us, before_ms = int(self._do("next_pass")), int(self._do("pass_before"))
        if (left_ns := at_us * NS_PER_US + 1 - int(self._do("clock_ns"))) > 0:
            yield Delay(left_ns)
        self._do("stop")
        return before_ms, at_us // US_PER_MS

    def poll(self, *, is_first: bool = False) -> Steps:
        """Make the pulses that are due; they take time. ``is_first``: of the pass, whose timers go by the
        time before it."""
        now_us = self.us
        end_us = int(self._do("poll" if is_first else "poll_again"))
        if end_us > now_us:
            yield Delay((end_us - now_us) * NS_PER_US)

    def go_on(self) -> None:
        """Give the pass back after the commands."""
        self._do("go_on")

    def finish(self) -> None:
        """Give the pass back after the servos: joints come next."""
        self._do("finish")

    def hold(self, ms: int, then_ms: int = 0) -> Steps:
        """Wait while pulses go on, and then again: the looks for pulses count from the beginning of each."""
        if ms > 0:
            self._do("hold", float(ms if then_ms else 0))
            yield Delay((ms + then_ms) * NS_PER_MS)
            self._do("stop")

    def pause_until_next_ms(self) -> Steps:
        """Wait for the next whole millisecond, as a loop does that only looks at the clock."""
        yield from self.pause(US_PER_MS - self.us % US_PER_MS)

    def pause(self, us: int) -> Steps:
        """Wait while nothing goes on."""
        if us > 0:
            self._do("stop")
            yield Delay(us * NS_PER_US)


def is_due(now_ms: int, last_ms: int, period_ms: int) -> bool:
    """Answer whether a timer of the board is due: it counts in 16 bits."""
    return (now_ms - last_ms) & 0xFFFF >= period_ms


def due_ms(now_ms: int, last_ms: int, period_ms: int) -> int:
    """Time at which a timer will be due, or is."""
    return now_ms + max(0, period_ms - ((now_ms - last_ms) & 0xFFFF))
