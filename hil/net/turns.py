"""Turns of clients: how much of the event loop a door's requests may take, and who is next."""

import asyncio
from collections import deque
from typing import Protocol

from hil.vocab.operation import Urgency

IN_A_PASS = 4
"""Requests of all clients between two looks at what else has come, as for serial ports: some 0.2 ms."""
SHARE = 0.15
"""Largest part of the time for several clients: what comes at a serial port is answered as soon as on a bench
without them (docs/benchmarks.md; with 0.4 it took up to twice as long)."""
BURST_S = 0.001
"""Time of turns that may be over the share, for clients that happen to ask at once."""


class Waiting(Protocol):
    """Waiting client."""

    def has_turn(self, most: int) -> None:
        """Answer some requests, and queue again if more of them wait."""


class Turns:
    """Turns on the running loop: so many in each pass, then those who wait, one after the other."""

    def __init__(self) -> None:
        self._left = IN_A_PASS
        self._lanes = {Urgency.COMMAND: deque[Waiting](), Urgency.READING: deque[Waiting]()}
        self._next: asyncio.Handle | None = None
        self._loop = asyncio.get_running_loop()
        self._last: object | None = None
        self._over_s, self._at_s = 0.0, self._loop.time()
        """Time that turns were over their share, at that time."""

    def take(self) -> bool:
        """Take a turn for one request, if this pass has one left."""
        if not self._left:
            return False
        self._left -= 1
        self._go_on_in_the_next_pass()
        return True

    async def wait(self, urgency: Urgency = Urgency.READING) -> None:
        """Wait for a turn for one request, and take it. A stop needs none."""
        if urgency is Urgency.STOP or (not self._waits(urgency) and self.take()):
            return
        waiting = self._loop.create_future()
        self.queue(_Sleeper(self, waiting), urgency)
        await waiting

    def _waits(self, urgency: Urgency = Urgency.READING) -> bool:
        """True if a request of this urgency, or of a higher one, waits."""
        return any(lane for each, lane in self._lanes.items() if each <= urgency)

    def _next_waiting(self) -> Waiting:
        return next(lane for lane in self._lanes.values() if lane).popleft()

    def note(self, client: object | None, took_s: float) -> None:
        """Note the CPU time that turns took. A client alone has no limit: it waits for each answer. None: one
        that does not, and has."""
        if client is None or client is not self._last:
            self._over_s += took_s
        self._last = client

    def queue(self, client: Waiting, urgency: Urgency = Urgency.READING) -> None:
        """Tell a client when it is its turn. Once for each call. Commands come before readings."""
        self._lanes[urgency].append(client)
        self._go_on_in_the_next_pass()

    def close(self) -> None:
        """Give no more turns."""
        for lane in self._lanes.values():
            lane.clear()
        if self._next:
            self._next.cancel()

    def _go_on_in_the_next_pass(self) -> None:
        if self._next is None:
            self._next = self._loop.call_soon(self._go_on)

    def _go_on(self) -> None:
        now_s = self._loop.time()
        self._over_s = max(0.0, self._over_s - SHARE * (now_s - self._at_s))
        self._at_s = now_s
        if self._over_s > BURST_S:
            self._left = 0
            self._next = self._loop.call_later(self._over_s / SHARE, self._go_on)
            return
        self._next = None
        self._left = IN_A_PASS
        while self._left and self._waits():
            client = self._next_waiting()
            client.has_turn(1 if self._waits() else self._left)
        if self._waits():
            self._go_on_in_the_next_pass()


class _Sleeper:
    """Client that waits for a turn. The future is done when it has one."""

    def __init__(self, turns: Turns, waiting: "asyncio.Future[None]") -> None:
        self._turns, self._waiting = turns, waiting

    def has_turn(self, most: int) -> None:
        if not self._waiting.done() and self._turns.take():
            self._waiting.set_result(None)
