"""A limit that is reached is said once, and then counted: a flood must not fill the log."""

from collections.abc import Callable
from typing import Protocol

AGAIN_S = 60.0
"""At most once in this time, one limit is spoken of."""


class Timer(Protocol):
    """What a loop's ``call_later`` answers."""

    def cancel(self) -> None:
        """Do not call."""


class Limit:
    """``count`` is how often it was reached. ``say`` gets a line for the log at once and, if it was reached
    again, one with the number after ``AGAIN_S``; ``call_later(seconds, call)`` is the event loop's."""

    def __init__(
        self, say: Callable[[str], object], call_later: Callable[[float, Callable[[], None]], Timer]
    ) -> None:
        self.count = 0
        self._say = say
        self._call_later = call_later
        self._timer: Timer | None = None
        self._told = 0
        self._text = ""

    def reached(self, text: str) -> None:
        """It stopped something: ``text`` says which limit, and what to do."""
        self.count += 1
        self._text = text
        if self._timer is None:
            self._tell(text)

    def _tell(self, text: str) -> None:
        self._say(text)
        self._told = self.count
        self._timer = self._call_later(AGAIN_S, self._later)

    def _later(self) -> None:
        self._timer = None
        if more := self.count - self._told:
            self._tell(f"{self._text} ({more} more in the last {AGAIN_S:g} s)")

    def close(self) -> None:
        """Say nothing more."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
