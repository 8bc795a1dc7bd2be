"""An event loop in simulated time."""

import asyncio
import selectors
from typing import Any

PATIENCE_S = 60.0


class Simulated(asyncio.SelectorEventLoop):
    """Loop in which nothing takes time but what sleeps."""

    def __init__(self) -> None:
        self.now_s = 0.0
        super().__init__(_Sleeping(self))

    def time(self) -> float:
        return self.now_s


class _Sleeping(selectors.DefaultSelector):
    def __init__(self, loop: Simulated) -> None:
        super().__init__()
        self._loop = loop

    def select(self, timeout: float | None = None) -> Any:
        if timeout is None:  # a thread's answer, of getaddrinfo
            events = super().select(PATIENCE_S)
            assert events, "everybody waits, and nothing will happen"
            return events
        self._loop.now_s += timeout
        return super().select(0)
