"""An event loop in simulated time."""

import asyncio
import selectors
from typing import Any


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
        assert timeout is not None, "everybody waits, and nothing will happen"
        self._loop.now_s += timeout
        return super().select(0)
