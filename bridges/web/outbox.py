"""Messages that wait for a page, in a bounded queue: who fills it asks first whether there is room."""

import asyncio
from collections import deque
from collections.abc import Callable, Iterable
from typing import NamedTuple

from aiohttp import web

from bridges.web.websocket_frames import FRAGMENT_BYTES, fragments

FULL_BYTES = 256 * 1024
"""Bytes that wait from which streams drop what they have: a tenth of a second of a busy bench."""
ANSWERS_BYTES = 1024 * 1024
"""Bytes that wait from which no request is read: its answer would have to wait too."""


class LongText(NamedTuple):
    """Text in parts, which other pages may have too, or which are made as they go out. ``size``: about how
    many bytes it holds while it waits; ``sent``: called when it has gone out, or never will."""

    parts: Iterable[bytes]
    size: int
    sent: Callable[[], object] = lambda: None


class Outbox:
    """Messages for one WebSocket, in order. ``can_write``: set while its transport has room."""

    def __init__(
        self, socket: web.WebSocketResponse, transport: asyncio.Transport, can_write: asyncio.Event
    ) -> None:
        self._socket, self._transport, self._can_write = socket, transport, can_write
        self._waiting: deque[str | bytes | LongText] = deque()
        self._bytes = 0
        self._came, self._went = asyncio.Event(), asyncio.Event()
        self.sent = 0
        """Number of messages that have gone out."""

    @property
    def is_full(self) -> bool:
        """True if streams have to drop what they have."""
        return self._bytes + self._transport.get_write_buffer_size() > FULL_BYTES

    def put(self, message: str | bytes | LongText) -> None:
        """Let a message wait for its turn."""
        if isinstance(message, str) and len(message) > FRAGMENT_BYTES:
            message = LongText((message.encode(),), len(message))
        self._waiting.append(message)
        self._bytes += _size(message)
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
                elif isinstance(message, bytes):
                    await self._socket.send_bytes(message)
                else:
                    await self._send_long(message)
                self._bytes -= _size(message)
                self.sent += 1
                self._went.set()

    async def _send_long(self, text: LongText) -> None:
        """Send a long text. What the socket sends by itself, pings and a close, may stand between."""
        try:
            for frame in fragments(text.parts):
                if self._transport.is_closing():
                    raise ConnectionResetError
                self._transport.write(frame)
                await asyncio.sleep(0)
                await self._can_write.wait()
        finally:
            text.sent()

    def drop(self) -> None:
        """Drop what waits: the page has gone."""
        for message in self._waiting:
            if isinstance(message, LongText):
                message.sent()
        self._waiting.clear()


def _size(message: str | bytes | LongText) -> int:
    return message.size if isinstance(message, LongText) else len(message)
