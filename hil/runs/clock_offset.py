"""Offset of another bench's clock from ours, from questions and answers."""

from collections import deque

WINDOW = 50
"""Number of exchanges that are remembered: five seconds of them, in which two quartz clocks part by under a
millisecond (100 ppm between them)."""


class ClockOffset:
    """Offset of another clock. The exchange with the shortest way there and back tells most: its answer was
    written within it, so the offset is known to half its length."""

    def __init__(self) -> None:
        self._exchanges: deque[tuple[int, int]] = deque(maxlen=WINDOW)

    def add(self, asked_ns: int, told_ns: int, heard_ns: int) -> None:
        """Add an exchange: a question left at ``asked_ns`` and its answer came at ``heard_ns`` of our clock;
        ``told_ns`` is the other clock's time in between."""
        self._exchanges.append((heard_ns - asked_ns, told_ns - (asked_ns + heard_ns) // 2))

    @property
    def offset_ns(self) -> int:
        """Difference to add to our time for the other's. 0 before the first exchange."""
        return min(self._exchanges, default=(0, 0))[1]

    @property
    def error_ns(self) -> int:
        """Maximum error of the offset."""
        return min(self._exchanges, default=(0, 0))[0] // 2
