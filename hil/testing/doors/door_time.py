"""Simulated time at the doors of a bench in memory, for clients that wait for answers."""

import asyncio
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from hil.testing.doors.client_loop import ClientLoop
from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs

if TYPE_CHECKING:
    from hil.memory_desk.door_loop import DoorLoop

TRIP_NS = 50_000
"""Time of a message to a door or back: together 0.1 ms, as at a door of this computer (docs/benchmarks.md).
A program that asks in a loop could wait for nothing if answers took no time."""
SILENCE_NS = 3600 * NS_PER_S
"""Simulated time after which a wait in which nothing comes is one without end."""


class NothingComes(Exception):
    """Error of a wait at a door that nothing ends: ``str(error)`` says for what."""


class DoorTime:
    """Time at the doors of a bench. ``loop``: runs the doors' tasks; ``run_until``: lets time pass;
    ``stop_ns``: time by which something happens by itself."""

    def __init__(
        self,
        loop: "DoorLoop",
        now_ns: Callable[[], SimTimeNs],
        run_until: Callable[[SimTimeNs], None],
        stop_ns: Callable[[], SimTimeNs],
    ) -> None:
        self.loop, self.now_ns = loop, now_ns
        self._run_until, self._stop_ns = run_until, stop_ns
        self.look_ns: int = FOREVER
        """Longest time between two looks whether something has come: shorter where doors tell what happens on
        the bench at times that nobody knows before."""
        self._clients: list[ClientLoop] = []
        self._under_way: deque[Callable[[], object]] = deque()

    def later(self, call: Callable[..., object], *given: object) -> None:
        """Call a function in the doors' loop when a message that leaves now has come. Messages keep their
        order. Nothing comes any more when the doors are closed."""
        if self.loop.is_closed():
            return
        self._under_way.append(partial(call, *given))  # timers of one time have no order
        self.loop.call_later(TRIP_NS / NS_PER_S, lambda: self._under_way.popleft()())

    def wait(self, ready: Callable[[], bool], until_ns: int, what: str) -> bool:
        """Let time pass until ``ready``, at most to ``until_ns``; answers whether it is. ``what``: what is
        waited for, for people.

        Raises:
            NothingComes: there is no end to it.
        """
        give_up_ns = self.now_ns() + SILENCE_NS
        while not ready():
            now_ns = self.now_ns()
            if now_ns >= until_ns:
                return False
            if now_ns >= give_up_ns:
                raise NothingComes(f"{what}: nothing has come for an hour of simulated time")
            self._run_until(SimTimeNs(min(until_ns, self._stop_ns(), now_ns + self.look_ns, give_up_ns)))
        return True

    @property
    def is_quiet(self) -> bool:
        """True if nothing can come from a door by itself."""
        return self.look_ns == self.loop.due_ns == FOREVER

    def join_running_loop(self) -> asyncio.AbstractEventLoop:
        """Let time pass for the event loop that runs now, while all its tasks wait; answers it."""
        loop = asyncio.get_running_loop()
        if not any(each.loop is loop for each in self._clients):
            self._clients.append(ClientLoop(loop, self))
        return loop

    def close(self) -> None:
        """Give the loops of clients their own time back, and end the doors' tasks."""
        for each in self._clients:
            each.leave()
        self._clients.clear()
        while self._under_way:  # as a door that is closed says that it is
            self._under_way.popleft()()
        self.loop.end()
