"""Simulated time: an ``int`` of nanoseconds since the bench's start, never a float, never wall time."""

from typing import NewType

SimTimeNs = NewType("SimTimeNs", int)

FOREVER = SimTimeNs(2**63 - 1)
"""The horizon of a group in which nobody waits for a time (the largest signed 64-bit value)."""

NS_PER_US = 1_000
NS_PER_MS = 1_000_000
NS_PER_S = 1_000_000_000


def ms(value: float) -> SimTimeNs:
    """Milliseconds to simulated nanoseconds, rounded to the nearest nanosecond."""
    return SimTimeNs(round(value * NS_PER_MS))
