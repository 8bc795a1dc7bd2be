"""Turns of clients: how much of the event loop a door's requests may take, and who is next."""

import asyncio
from collections import deque
from typing import Protocol

from hil.vocab.address import owner_of
from hil.vocab.operation import Urgency
from hil.vocab.verbs import VerbRefused

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


class FairShare:
    """Turns on the running loop: so many in each pass, then those who wait, one after the other."""

    def __init__(self) -> None:
        self._left = IN_A_PASS
        self._lanes = {Urgency.COMMAND: deque[Waiting](), Urgency.READING: deque[Waiting]()}
        self._sleepers: set[_Sleeper] = set()
        self._next: asyncio.Handle | None = None
        self._loop = asyncio.get_running_loop()
        self._last: object | None = None
        self._over_s, self._at_s = 0.0, self._loop.time()
        """Time that turns were over their share, at that time."""

    def spend(self) -> bool:
        """Take a turn for one request, if this pass has one left."""
        if not self._left:
            return False
        self._left -= 1
        self._go_on_in_the_next_pass()
        return True

    async def wait(self, urgency: Urgency = Urgency.READING, moves: str = "") -> None:
        """Wait for a turn for one request, and take it. A stop needs none. ``moves``: the device, or axis of
        one, that is told a verb.

        Raises:
            VerbRefused: a stop of it came meanwhile; the verb would move it afterwards.
        """
        if urgency is Urgency.STOP or (not self._waits(urgency) and self.spend()):
            return
        sleeper = _Sleeper(self, self._loop.create_future(), moves)
        self._sleepers.add(sleeper)
        try:
            self.queue(sleeper, urgency)
            await sleeper.waiting
        finally:
            self._sleepers.discard(sleeper)
        if sleeper.is_overtaken:
            raise VerbRefused("not_now", f"a stop of {moves} came while this waited; ask for it again")

    def stopped(self, name: str) -> None:
        """Refuse the verbs of a device, or axis of one, that wait: a stop of it was carried out. An empty
        name: of all."""
        for sleeper in self._sleepers:
            if sleeper.moves and name in ("", sleeper.moves, owner_of(sleeper.moves)):
                sleeper.is_overtaken = True

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
    """Client that waits for a turn. ``waiting``: done when it has one."""

    def __init__(self, turns: FairShare, waiting: "asyncio.Future[None]", moves: str) -> None:
        self._turns, self.waiting, self.moves = turns, waiting, moves
        self.is_overtaken = False

    def has_turn(self, most: int) -> None:
        if not self.waiting.done() and self._turns.spend():
            self.waiting.set_result(None)
