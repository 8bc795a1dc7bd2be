"""One connection of Modbus TCP. What needs no waiting is answered where it comes in; the rest, and what is
behind it, when its turn has come: answers are in the order of requests."""

import asyncio
from collections import deque
from collections.abc import Callable, Coroutine
from typing import Any, cast

from bridges.modbus.request_handler import Asker, RequestHandler
from hil.net.visitors import Visit
from hil.wire.modbus.mbap import MbapPacket, MbapSplitter, encode

AT_ONCE = 16
"""Requests of a client between two turns of others: half a millisecond."""


class TcpClient(asyncio.Protocol):
    """Connection of a client. ``known``: finds out who it is once it is connected, None: it may not ask."""

    def __init__(
        self, handler: RequestHandler, visit: Visit, known: Callable[[asyncio.Transport], Asker | None]
    ) -> None:
        self._handler, self._visit, self._known = handler, visit, known
        self._splitter = MbapSplitter()
        self._waiting: deque[MbapPacket] = deque()
        self._asked: tuple[MbapPacket, Coroutine[Any, Any, bytes]] | None = None
        """Request that is being carried out, and takes time."""
        self._asker: Asker | None = None
        self._loop = asyncio.get_running_loop()
        self._has_gone = False
        self._turn, self._can_write = asyncio.Event(), asyncio.Event()
        self._can_write.set()

    @property
    def fault(self) -> str:
        """What is wrong with its framing, after which nothing is read."""
        return self._splitter.fault

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        if (asker := self._known(self._transport)) is None:
            self._transport.abort()
        self._asker = asker

    def data_received(self, data: bytes) -> None:
        self._waiting += self._splitter.feed(data)
        self._visit.since_s = self._loop.time()
        if not self._visit.is_busy:
            self._answer_some()

    def _answer_some(self) -> None:
        """Answer some of the requests that wait, up to one that takes time."""
        answers, asker = bytearray(), self._asker
        for _ in range(AT_ONCE if asker else 0):
            if not self._waiting:
                break
            packet = self._waiting.popleft()
            self._visit.has_asked = True
            answer = self._handler.answer(asker, packet.unit, packet.pdu)  # type: ignore[arg-type]
            if not isinstance(answer, bytes):
                self._asked = packet, answer
                break
            answers += encode(packet.transaction, packet.unit, answer)
        if answers:
            self._transport.write(bytes(answers))
        if self._asked or self._waiting:
            self._visit.is_busy = True
            self._transport.pause_reading()
            self._turn.set()
        elif self._splitter.fault:
            self._transport.close()

    async def serve(self) -> None:
        """Answer what has to wait, until the client has gone."""
        try:
            while not self._has_gone:
                await self._turn.wait()
                self._turn.clear()
                while self._visit.is_busy and not self._has_gone:
                    await self._go_on()
        finally:
            self.forget()
            self._transport.abort()

    def forget(self) -> None:
        """Drop the request that is being carried out, if any."""
        if self._asked:
            self._asked[1].close()
            self._asked = None

    async def _go_on(self) -> None:
        if self._asked:
            packet, asked = self._asked
            answer = await asked
            self._asked = None
            self._transport.write(encode(packet.transaction, packet.unit, answer))
        else:
            await asyncio.sleep(0)  # the turn of others
        self._visit.is_busy = False  # who does not read the answers gives way to others
        await self._can_write.wait()
        self._answer_some()
        if not self._visit.is_busy and not self._transport.is_closing():
            self._transport.resume_reading()

    def pause_writing(self) -> None:
        self._can_write.clear()

    def resume_writing(self) -> None:
        self._can_write.set()

    def connection_lost(self, error: Exception | None) -> None:
        self._has_gone = True
        self._can_write.set()
        self._turn.set()
