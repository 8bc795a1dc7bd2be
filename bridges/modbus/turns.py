"""Turns of clients: how much of a pass of the event loop the door's requests may take."""

import asyncio
from collections import deque
from typing import Protocol

IN_A_PASS = 4
"""Requests of all clients between two looks at what else has come, as for serial ports: some 0.2 ms."""


class Waiting(Protocol):
    """Waiting client."""

    def has_turn(self, most: int) -> None:
        """Answer some requests, and queue again if more of them wait."""


class Turns:
    """Turns on the running loop: so many in each pass, then those who wait, one after the other."""

    def __init__(self) -> None:
        self._left = IN_A_PASS
        self._queue: deque[Waiting] = deque()
        self._next: asyncio.Handle | None = None

    def take(self) -> bool:
        """Take a turn for one request, if this pass has one left."""
        if not self._left:
            return False
        self._left -= 1
        self._go_on_in_the_next_pass()
        return True

    def queue(self, client: Waiting) -> None:
        """Tell a client when it is its turn. Once for each call."""
        self._queue.append(client)
        self._go_on_in_the_next_pass()

    def _go_on_in_the_next_pass(self) -> None:
        if self._next is None:
            self._next = asyncio.get_running_loop().call_soon(self._go_on)

    def _go_on(self) -> None:
        self._next = None
        self._left = IN_A_PASS
        while self._left and self._queue:
            client = self._queue.popleft()
            client.has_turn(1 if self._queue else self._left)
        if self._queue:
            self._go_on_in_the_next_pass()
