"""Event loop of a test's own program, on the time of a bench."""

import asyncio
from collections.abc import Callable
from typing import Any, Protocol

from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs


class PassingTime(Protocol):
    """Time that passes while somebody waits, a ``hil.testing.doors.door_time.DoorTime``."""

    def now_ns(self) -> SimTimeNs:
        """Present simulated time."""

    def wait(self, ready: Callable[[], bool], until_ns: int, what: str) -> bool:
        """Let time pass until ``ready``, at most to ``until_ns``."""

    @property
    def is_quiet(self) -> bool:
        """True if nothing can come by itself."""


class ClientLoop:
    """Event loop whose clock is the bench's from now on, until ``leave``: while all its tasks wait, simulated
    time passes. What waits for files, threads and processes is looked at in between; where nothing
    else can come, they are waited for."""

    def __init__(self, loop: asyncio.AbstractEventLoop, time: PassingTime) -> None:
        whole: Any = loop
        if not hasattr(whole, "_selector"):
            raise TypeError(
                f"{type(loop).__name__} keeps its time to itself; use an event loop of asyncio's own"
            )
        if isinstance(getattr(whole.time, "__self__", loop), ClientLoop):
            raise ValueError("this event loop is on the time of another bench already")
        self.loop, self._whole, self._time = loop, whole, time
        self._own_time, self._own_select = loop.time, whole._selector.select
        self._offset_s = loop.time() - time.now_ns() / NS_PER_S
        whole.time, whole._selector.select = self._now_s, self._select

    def _now_s(self) -> float:
        return self._time.now_ns() / NS_PER_S + self._offset_s

    def _select(self, timeout: float | None = None) -> Any:
        """Files that are ready; where none is, and nothing else, simulated time passes up to the time-out."""
        found = self._own_select(0)
        if found or timeout == 0:
            return found
        until_ns = FOREVER if timeout is None else self._time.now_ns() + max(1, round(timeout * NS_PER_S))

        def is_over() -> bool:
            nonlocal found
            found = self._own_select(0)
            return bool(found or self._whole._ready or (timeout is None and self._time.is_quiet))

        self._time.wait(is_over, until_ns, "the event loop of the test, all of whose tasks wait")
        return found if found or self._whole._ready or timeout is not None else self._own_select(None)

    def leave(self) -> None:
        """Give the loop its own time back; what it has waited for so far it need not wait for again."""
        if self.loop.is_closed():
            return
        ahead_s = self._now_s() - self._own_time()
        own_time = self._own_time
        self._whole.time = lambda: own_time() + ahead_s
        self._whole._selector.select = self._own_select
