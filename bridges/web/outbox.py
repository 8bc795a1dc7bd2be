"""What waits for a page. It never grows without end: who fills it asks first whether there is room."""

import asyncio
from collections import deque
from collections.abc import Callable

from aiohttp import web

FULL_BYTES = 256 * 1024
"""Bytes that wait from which streams drop what they have: a tenth of a second of a busy bench."""
ANSWERS_BYTES = 1024 * 1024
"""Bytes that wait from which no request is read: its answer would have to wait too."""


class Outbox:
    """Messages for one WebSocket, in order. ``in_transport``: bytes of them that the system has not taken."""

    def __init__(self, socket: web.WebSocketResponse, in_transport: Callable[[], int]) -> None:
        self._socket, self._in_transport = socket, in_transport
        self._waiting: deque[str | bytes] = deque()
        self._bytes = 0
        self._came, self._went = asyncio.Event(), asyncio.Event()
        self.sent = 0
        """Number of messages that have gone out."""

    @property
    def is_full(self) -> bool:
        """True if streams have to drop what they have."""
        return self._bytes + self._in_transport() > FULL_BYTES

    def put(self, message: str | bytes) -> None:
        """Let a message wait for its turn."""
        self._waiting.append(message)
        self._bytes += len(message)
        self._came.set()

    async def room(self) -> None:
        """Wait until there is room for another answer."""
        while self._bytes > ANSWERS_BYTES:
            self._went.clear()
            await self._went.wait()

    async def send_all(self) -> None:
        """Send what waits and what comes, until the socket is closed.

        Raises:
            OSError: the page has gone.
        """
        while True:
            await self._came.wait()
            self._came.clear()
            while self._waiting:
                message = self._waiting.popleft()
                if isinstance(message, str):
                    await self._socket.send_str(message)
                else:
                    await self._socket.send_bytes(message)
                self._bytes -= len(message)
                self.sent += 1
                self._went.set()
