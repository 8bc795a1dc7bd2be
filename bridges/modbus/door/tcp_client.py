"""One connection of Modbus TCP. What needs no waiting is answered where it comes in, as long as it is the
client's turn; the rest, and what is behind it, later: answers are in the order of requests."""

import asyncio
import logging
import socket
import ssl
from collections import Counter, deque
from collections.abc import Callable, Coroutine, Mapping
from time import thread_time
from typing import Any, cast

from bridges.modbus.door import certificate_files
from bridges.modbus.door.client_role import NoRole, role_of
from bridges.modbus.door.door_options import Certificates
from bridges.modbus.door.request_handler import Asker, RequestHandler
from bridges.modbus.protocol.mbap import MbapPacket, MbapSplitter, encode
from bridges.modbus.protocol.pdu import is_write
from hil.net.acceptor import abort
from hil.net.fair_share import FairShare
from hil.net.visitors import Limit, Visit, Visitors
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.desk_protocol import Source
from hil.vocab.operation import Urgency
from hil.vocab.verbs import Role

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


log = logging.getLogger("hil")

CONNECTIONS = 64
HANDSHAKE_S = 5.0
_ANYBODY = Source("modbus client", Role.OPERATOR, door="modbus")


class TcpConnections:
    """Connections of Modbus TCP. ``certificates``: None: every client is an operator. ``closed``:
    connections that were closed by the door, by reason. ``turns``: makes the turns that clients have."""

    def __init__(
        self,
        handler: RequestHandler,
        certificates: Certificates | None,
        turns: Callable[[], FairShare] = FairShare,
    ) -> None:
        self._handler, self._make_turns = handler, turns
        self._roles: Mapping[str, str] = certificates.roles if certificates else {}
        self._tls = _context(certificates) if certificates else None
        self._visitors: Visitors | None = None
        self.closed: Counter[str] = Counter()

    def listen(self, listeners: list[socket.socket]) -> None:
        loop = asyncio.get_running_loop()
        self._said = Limit(log.info, loop)
        self._turns = self._make_turns()
        self._visitors = Visitors("modbus", CONNECTIONS, loop, self._stay, log.warning)
        for listener in listeners:
            self._visitors.listen(listener)

    def admit(self, connection: Any) -> None:
        """Let a client in that came without a listener, as ``connect`` takes it, or refuse it."""
        assert self._visitors is not None
        self._visitors.admit(connection)

    @property
    def count(self) -> int:
        return len(self._visitors.visits) if self._visitors else 0

    @property
    def turned_away(self) -> int:
        return self._visitors.turned_away if self._visitors else 0

    async def close(self) -> None:
        if self._visitors:
            self._visitors.close()
            self._turns.close()
            await asyncio.gather(*self._visitors.send_away(), return_exceptions=True)
            self._said.close()

    async def _stay(self, connection: socket.socket, visit: Visit) -> None:
        client = TcpClient(self._handler, self._turns, visit, self._known)
        try:
            await self.connect(connection, client)
        except OSError as error:  # of ssl, too
            self._close("tls", str(error))
            connection.close()
            return
        except BaseException:
            client.forget()  # with TLS its first request may be there already
            connection.close()
            raise
        await client.serve()
        if client.fault:
            self._close("framing", client.fault)

    async def connect(self, connection: Any, client: TcpClient) -> None:
        """Connect a client to its socket. Raises OSError: there is no connection, or no TLS."""
        # Asyncio does so for its own sockets alone; without it an answer waits 40 ms for the one before.
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        await asyncio.get_running_loop().connect_accepted_socket(
            lambda: client,
            connection,
            ssl=self._tls,
            ssl_handshake_timeout=HANDSHAKE_S if self._tls else None,
        )

    def _known(self, transport: asyncio.Transport) -> Asker | None:
        """The client's address and role. None: it has no role."""
        if self._tls is None:
            return Asker(_ANYBODY)
        certificate = transport.get_extra_info("ssl_object").getpeercert(binary_form=True)
        try:
            name, role = role_of(certificate or b"", self._roles)
        except NoRole as error:
            self._close("role", str(error))
            return None
        return Asker(Source(f"modbus client {name}", role, door="modbus"))

    def _close(self, reason: str, why: str) -> None:
        self.closed[reason] += 1
        self._said.reached(f"bridges.modbus: a connection was closed: {why}")


def _context(certificates: Certificates) -> ssl.SSLContext:
    """TLS of the door. Raises BridgeError: a file cannot be used."""
    files = certificates.files
    for option, message, remedy in certificate_files.problems(files):
        raise BridgeError(f"tls.{option}: {message}; {remedy}")
    try:
        return certificate_files.context(files)
    except (OSError, ValueError) as error:  # what no check finds
        raise BridgeError(f"tls: {error}") from None
