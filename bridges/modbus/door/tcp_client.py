"""One connection of Modbus TCP. What needs no waiting is answered where it comes in, as long as it is the
client's turn; the rest, and what is behind it, later: answers are in the order of requests."""

import asyncio
from collections import deque
from collections.abc import Callable, Coroutine
from time import thread_time
from typing import Any, cast

from bridges.modbus.door.request_handler import Asker, RequestHandler
from bridges.modbus.protocol.mbap import MbapPacket, MbapSplitter, encode
from bridges.modbus.protocol.pdu import is_write
from hil.net.acceptor import abort
from hil.net.fair_share import FairShare
from hil.net.visitors import Visit
from hil.vocab.operation import Urgency

HELD = 16
"""Requests that may wait for their turn while more are read."""


class TcpClient(asyncio.Protocol):
    """Connection of a client. ``known``: finds out who it is once it is connected, None: it may not ask."""

    def __init__(
        self,
        handler: RequestHandler,
        turns: FairShare,
        visit: Visit,
        known: Callable[[asyncio.Transport], Asker | None],
    ) -> None:
        self._handler, self._turns, self._visit, self._known = handler, turns, visit, known
        self._splitter = MbapSplitter()
        self._waiting: deque[MbapPacket] = deque()
        self._asked: tuple[MbapPacket, Coroutine[Any, Any, bytes]] | None = None
        """Request that is being carried out, and takes time."""
        self._asker: Asker | None = None
        self._loop = asyncio.get_running_loop()
        self._has_gone = False
        self._asks, self._can_write = asyncio.Event(), True

    @property
    def fault(self) -> str:
        """Error of its framing, after which nothing is read."""
        return self._splitter.fault

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        if (asker := self._known(self._transport)) is None:
            abort(self._transport)
        self._asker = asker

    def data_received(self, data: bytes) -> None:
        if self._asker is None:
            return
        self._waiting += self._splitter.feed(data)
        self._visit.since_s = self._loop.time()
        if self._can_write and not self._visit.is_busy:
            self._answer_some(HELD)
        elif len(self._waiting) > HELD:
            self._transport.pause_reading()

    def has_turn(self, most: int) -> None:
        """Answer some requests. A client that does not read the answers gives way to others."""
        self._visit.is_busy = False
        if self._can_write and not self._has_gone:
            self._answer_some(most)
            if not self._visit.is_busy and not self._transport.is_closing():
                self._transport.resume_reading()

    def _answer_some(self, most: int) -> None:
        """Answer some of the requests that wait, up to one that takes time."""
        answers, began_s = bytearray(), thread_time()
        while most and self._waiting and self._turns.spend():
            most -= 1
            packet = self._waiting.popleft()
            self._visit.has_asked = True
            answer = self._handler.answer(self._asker, packet.unit, packet.pdu)  # type: ignore[arg-type]
            if not isinstance(answer, bytes):
                self._asked = packet, answer
                break
            answers += encode(packet.transaction, packet.unit, answer)
        if answers:
            self._transport.write(bytes(answers))
        self._turns.note(self, thread_time() - began_s)
        if self._asked:
            self._visit.is_busy = True
            self._transport.pause_reading()
            self._asks.set()
        elif self._waiting:
            self._visit.is_busy = True
            if len(self._waiting) > HELD:
                self._transport.pause_reading()
            self._turns.queue(self, Urgency.COMMAND if is_write(self._waiting[0].pdu) else Urgency.READING)
        elif self._splitter.fault:
            self._transport.close()

    async def serve(self) -> None:
        """Carry out what takes time, until the client has gone."""
        try:
            while not self._has_gone:
                await self._asks.wait()
                self._asks.clear()
                if self._asked:
                    packet, asked = self._asked
                    answer = await asked
                    self._asked = None
                    self._transport.write(encode(packet.transaction, packet.unit, answer))
                    self.has_turn(HELD)
        finally:
            self.forget()
            abort(self._transport)

    def forget(self) -> None:
        """Drop the request that is being carried out, if any."""
        if self._asked:
            self._asked[1].close()
            self._asked = None

    def pause_writing(self) -> None:
        self._can_write = False

    def resume_writing(self) -> None:
        self._can_write = True
        if not self._visit.is_busy:
            self.has_turn(HELD)

    def connection_lost(self, error: Exception | None) -> None:
        self._has_gone = True
        self._asks.set()
