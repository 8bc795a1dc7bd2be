"""Echo of an adapter on the event loop: bytes out and in, and the timer of what is held."""

import asyncio
import logging
from collections.abc import Callable
from typing import Protocol

from hil.vocab.ports import EchoState, EchoStats
from hil.vocab.time import FOREVER, NS_PER_S

log = logging.getLogger("hil")


class EchoFilter(Protocol):
    """Filter of what was just sent on a line, without I/O: ``hil.wire.echo.Echo``."""

    @property
    def told(self) -> EchoStats:
        """Counters of what was dropped, and whether the line has an echo."""

    def sent(self, data: bytes, at_ns: int) -> None:
        """Note bytes that go out."""

    def received(self, data: bytes) -> bytes:
        """Take bytes that came; answers those of others."""

    def due_ns(self) -> int:
        """Time at which ``advance`` has something to do; ``FOREVER``: nothing."""

    def advance(self, now_ns: int) -> bytes:
        """Do what is due; answers bytes that were held and are others'."""


class EchoGuard:
    """Filter of a line that is open. ``deliver`` gets what is others'. ``line``: its name in the log.

    What the loop reads in a pass is taken before time that has passed is noted: after a stall of the loop an
    echo that came in time is still one.
    """

    def __init__(self, echo: EchoFilter, deliver: Callable[[bytes], None], line: str) -> None:
        self._echo, self._deliver, self._line = echo, deliver, line
        self._loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None
        self._state = echo.told.state

    def sent(self, data: bytes) -> None:
        """Note bytes that go out now."""
        self._echo.sent(data, self._now_ns())
        self._wait()

    def received(self, data: bytes) -> None:
        """Take bytes that came."""
        self._go_on(self._echo.received(data))

    def close(self) -> None:
        """Stop: what is held is lost."""
        if self._timer:
            self._timer.cancel()
            self._timer = None

    def _now_ns(self) -> int:
        return round(self._loop.time() * NS_PER_S)

    def _wait(self) -> None:
        """Set the timer, unless it goes off early enough."""
        due_ns = self._echo.due_ns()
        if due_ns < FOREVER and (self._timer is None or self._timer.when() * NS_PER_S > due_ns):
            self.close()
            self._timer = self._loop.call_at(due_ns / NS_PER_S, self._advance)

    def _advance(self) -> None:
        self._timer = None
        self._go_on(self._echo.advance(self._now_ns()))

    def _go_on(self, data: bytes) -> None:
        self._wait()
        if (state := self._echo.told.state) is not self._state:
            self._state = state
            if state is EchoState.YES:
                log.info("%s: the adapter echoes what is sent: it is dropped", self._line)
        if data:
            self._deliver(data)
