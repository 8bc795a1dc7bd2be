"""Warnings of the daemon's log as events of its bench: what nobody else tells, for those who look later."""

import asyncio
import logging
import time
from collections.abc import Callable
from contextlib import suppress
from itertools import islice

from hil.operations.event_log import EventLog
from hil.operations.seen_events import HERE

KIND = "log"
MOST_PER_S = 50
"""Maximum number of lines that become events in a second; a flood has no room of the recording."""
_LOOKED_AT = 8
"""Latest events that may say the same."""
_EARLY = 100
"""Maximum number of lines that wait for the bench's events."""


class SaidEvents(logging.Handler):
    """Handler of the process's log, of any thread, for warnings and errors: a line below them may have the
    token of a run. Lines wait until ``begin`` names the events."""

    def __init__(self, loop: asyncio.AbstractEventLoop, is_device: Callable[[str], bool]) -> None:
        super().__init__(logging.WARNING)
        self._loop, self._is_device = loop, is_device
        self._events: EventLog | None = None
        self._early: list[tuple[str, str]] = []
        self._second = 0
        self._noted = self._left_out = 0

    def begin(self, events: EventLog) -> None:
        """Put lines into these events from now on, and those that waited."""
        self._events = events
        early, self._early = self._early, []
        for level, text in early:
            self._put(level, text)

    def end(self) -> None:
        """Note nothing more."""
        self._events, self._is_device = None, lambda name: False
        logging.getLogger().removeHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        if (second := int(time.monotonic())) != self._second:
            left_out, self._noted, self._left_out, self._second = self._left_out, 0, 0, second
            if left_out:
                self._note("WARNING", f"{left_out} lines of the log are left out here: too many came")
        self._noted += 1
        if self._noted > MOST_PER_S:
            self._left_out += 1
            return
        try:
            text = record.getMessage()
        except Exception:  # a message whose arguments do not fit it
            self.handleError(record)
            return
        if record.exc_info and (error := record.exc_info[1]):
            text = f"{text}: {error!r}"
        self._note(record.levelname, " ".join(text.split()))

    def _note(self, level: str, text: str) -> None:
        with suppress(RuntimeError):  # the bench has ended
            self._loop.call_soon_threadsafe(self._put, level, text)

    def _put(self, level: str, text: str) -> None:
        if self._events is None:
            if len(self._early) < _EARLY:
                self._early.append((level, text))
            return
        latest = islice(self._events.latest_first(), _LOOKED_AT)
        if any(each["text"] in text for each in latest if each["text"]):
            return  # an event says it already
        of, colon, rest = text.partition(": ")
        if not (colon and self._is_device(of)):
            of, rest = "", text
        self._events.put(KIND, of, HERE, f"{level} {rest}")
