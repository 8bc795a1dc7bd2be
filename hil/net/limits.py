"""Limits that are logged once when they are reached, and then counted: a flood must not fill the log."""

import asyncio
from collections.abc import Callable

AGAIN_S = 60.0
"""Minimum time between two log lines on one limit."""


class Limit:
    """Limit. ``count`` is how often it was reached. ``say`` gets a line for the log at once and, if it was
    reached again, one with the number after ``AGAIN_S``."""

    def __init__(self, say: Callable[[str], object], loop: asyncio.AbstractEventLoop) -> None:
        self.count = 0
        self._say = say
        self._loop = loop
        self._timer: asyncio.TimerHandle | None = None
        self._told = 0
        self._text = ""

    def reached(self, text: str) -> None:
        """Count that the limit stopped something: ``text`` says which limit, and what to do."""
        self.count += 1
        self._text = text
        if self._timer is None:
            self._tell(text)

    def _tell(self, text: str) -> None:
        self._say(text)
        self._told = self.count
        self._timer = self._loop.call_later(AGAIN_S, self._later)

    def _later(self) -> None:
        self._timer = None
        if more := self.count - self._told:
            self._tell(f"{self._text} ({more} more in the last {AGAIN_S:g} s)")

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
