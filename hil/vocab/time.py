"""Simulated time: an ``int`` of nanoseconds since the bench's start, never a float, never wall time."""

from collections.abc import Callable
from typing import NewType, Protocol

SimTimeNs = NewType("SimTimeNs", int)

FOREVER = SimTimeNs(2**63 - 1)
"""The horizon of a group in which nobody waits for a time (the largest signed 64-bit value)."""


class Clock(Protocol):
    """Simulated time, for what has to happen at times of its own."""

    @property
    def now_ns(self) -> SimTimeNs:
        """Present simulated time."""

    def at(self, at_ns: int, call: Callable[[SimTimeNs], None]) -> None:
        """Schedule a call for a time not reached yet; calls of one time run in the order of scheduling."""


NS_PER_US = 1_000
NS_PER_MS = 1_000_000
NS_PER_S = 1_000_000_000


def ms(value: float) -> SimTimeNs:
    """Convert milliseconds to simulated nanoseconds, rounded to the nearest nanosecond."""
    return SimTimeNs(round(value * NS_PER_MS))
