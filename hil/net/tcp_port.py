"""Port behind a TCP listener: clients share it as terminals share a line. Each kind wraps bytes its way."""

import asyncio
import logging
import resource
import socket
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Protocol

from pydantic import Field

from hil.net.acceptor import ACCEPT_AGAIN_S, Acceptor
from hil.net.endpoint import authority, endpoint
from hil.net.line_openings import tell_opened
from hil.net.listen_option import ListenOptions
from hil.net.listeners import ListenRefused, listeners_at
from hil.net.traffic import Outgoing, Traffic
from hil.net.visitors import Limit
from hil.vocab.ports import PortContext, PortError, PortHost, PortStats

_READ_BYTES = 65536
_LOOK_EVERY_S = 5.0
RESERVED_FDS = 32
"""Last file descriptors, which no client gets: the boards' memories and the control socket need some."""
KEEP_ALIVE = {"TCP_KEEPIDLE": 10, "TCP_KEEPINTVL": 5, "TCP_KEEPCNT": 3}
"""Silence and time between probes in seconds, number of probes: a client has vanished after 25 s."""
_TRIES = 7
"""Number of tries for a client that data waits for: sent again after 0.2 s, 0.4 s and so on, 25 s in all."""
_TCP_INFO_BYTES = 4  # state, ca_state, retransmits, probes: the begin of struct tcp_info, linux/tcp.h

log = logging.getLogger("hil")


class TcpOptions(ListenOptions):
    """Address to listen at, and maximum number of clients."""

    max_clients: int = Field(
        default=32, ge=1, le=1000, description="Clients at a time; one more is turned away (closed at once)."
    )


class Codec(Protocol):
    """Codec of a client's bytes."""

    baud: int | None
    dtr: bool
    """True while the client has DTR on."""
    rises: int
    """Number of times that it has switched DTR on, since it came."""

    @property
    def hello(self) -> bytes:
        """Bytes that a client is sent when it comes."""

    def decode(self, data: bytes) -> tuple[bytes, bytes]:
        """Decode bytes of the line, never more than came, and what to answer the client."""

    def encode(self, data: bytes) -> bytes:
        """Encode bytes of the line for the client."""


class Plain:
    """Codec that changes nothing."""

    baud: int | None = None
    dtr, rises = True, 0
    hello = b""

    def decode(self, data: bytes) -> tuple[bytes, bytes]:
        return data, b""

    def encode(self, data: bytes) -> bytes:
        return data


class Client:
    """Client of a listener. ``out`` is what is sent to it; ``drained`` and ``traffic`` as ``Outgoing``.

    The owner reads ``connection`` and calls ``close`` when it ends, or when ``died`` is called, from the
    event loop: what such a client has sent and was not read yet is void.
    """

    def __init__(
        self,
        connection: socket.socket,
        loop: asyncio.AbstractEventLoop,
        traffic: Traffic,
        drained: Callable[[], None],
        died: Callable[["Client"], None],
    ) -> None:
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in KEEP_ALIVE.items():
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
        self.connection = connection
        self._loop = loop
        self._died = died
        self.out = Outgoing(connection.fileno(), connection.send, loop, traffic, drained, self._failed)

    def _failed(self, error: OSError) -> None:
        self._loop.call_soon(self._died, self)

    def has_vanished(self) -> bool:
        """True if the client's computer acknowledges nothing any more; that of a client that only does not
        read still does."""
        info = self.connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _TCP_INFO_BYTES)
        retransmits, probes = info[2:4]
        return retransmits >= _TRIES or probes >= _TRIES

    def close(self) -> None:
        self.out.stop()
        self._loop.remove_reader(self.connection)
        self.connection.close()


def has_dtr(codecs: Iterable[Codec], but: Codec | None = None) -> bool:
    """True if a client has DTR on, another one than ``but``."""
    return any(codec.dtr for codec in codecs if codec is not but)


class TcpPort:
    """``Port`` behind a TCP listener. What a client sends is merged in order of arrival; what the device
    sends goes to all.

    ``tx_bytes`` and ``dropped_bytes`` count each client's copy: a byte sent to two clients counts twice. A
    client that shuts down its sending side has left.
    """

    def __init__(
        self,
        options: TcpOptions,
        context: PortContext,
        codec: Callable[[], Codec] = Plain,
        scheme: str = "socket",
    ) -> None:
        self._options = options
        self._make_codec = codec
        self._scheme = scheme
        self._codecs: dict[Client, Codec] = {}
        self._last_codec: Codec | None = None
        self._title = f"tcp port of {context.device}"
        self._at, self._number = endpoint(options.listen)
        self._acceptor: Acceptor | None = None
        self._look_timer: asyncio.TimerHandle | None = None
        self._clients: dict[int, Client] = {}
        self._reading = True
        self._traffic = Traffic()

    @property
    def address(self) -> str:
        return f"{self._scheme}://{authority(self._at, self._number)}"

    async def open(self, host: PortHost) -> None:
        self._host = host
        self._loop = asyncio.get_running_loop()
        try:
            (listener,) = await listeners_at(*endpoint(self._options.listen), most=1)
        except ListenRefused as refused:
            raise PortError(str(refused), "listen") from refused
        self._full = Limit(log.warning, self._loop)
        self._out_of_fds = Limit(log.warning, self._loop)
        self._number = listener.getsockname()[1]
        self._acceptor = Acceptor(listener, self._loop, self._came, self._wait)

    def _wait(self, why: str) -> float:
        self._out_of_fds.reached(f"{self._title}: new clients have to wait: {why}")
        return ACCEPT_AGAIN_S

    def _came(self, connection: socket.socket) -> None:
        self._traffic.connects += 1
        if self._is_room_for(connection):
            self._take(connection)
        else:
            connection.close()

    def _is_room_for(self, connection: socket.socket) -> bool:
        if len(self._clients) >= self._options.max_clients:
            self._full.reached(
                f"{self._title}: {len(self._clients)} clients are connected, another one was turned away; "
                "max_clients: of this port allows more"
            )
            return False
        most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        if connection.fileno() >= most - RESERVED_FDS:
            self._out_of_fds.reached(
                f"{self._title}: {most} files are open at most, a client was turned away; "
                "raise the limit (ulimit -n, LimitNOFILE=)"
            )
            return False
        return True

    def _take(self, connection: socket.socket) -> None:
        client = Client(connection, self._loop, self._traffic, self._client_drained, self._forget)
        self._clients[connection.fileno()] = client
        if not has_dtr(self._codecs.values()):
            tell_opened(self._host)
        self._codecs[client] = self._last_codec = codec = self._make_codec()
        with suppress(
            OSError
        ):  # uncounted: nothing of the device; a client that has gone is found by reading
            connection.send(codec.hello)
        if self._reading:
            self._read_from(client)
        if self._look_timer is None:
            self._look_timer = self._loop.call_later(_LOOK_EVERY_S, self._look)

    def _look(self) -> None:
        """Drop clients whose computer has vanished."""
        for client in list(self._clients.values()):
            if client.has_vanished():
                self._forget(client)
        self._look_timer = self._loop.call_later(_LOOK_EVERY_S, self._look) if self._clients else None

    def _client_drained(self) -> None:
        # Later, because the host may answer with a write, and this may be in the middle of one.
        self._loop.call_soon(self._tell_drained)

    def _tell_drained(self) -> None:
        if self._acceptor is not None and self.backlog() == 0:
            self._host.drained()

    def write(self, data: bytes) -> None:
        if not self._clients:
            self._traffic.unheard_bytes += len(data)
        for client in self._clients.values():
            client.out.write(self._codecs[client].encode(data))

    def resume_reading(self) -> None:
        if not self._reading:
            self._reading = True
            for client in self._clients.values():
                self._read_from(client)

    def _read_from(self, client: Client) -> None:
        self._loop.add_reader(client.connection, self._readable, client)

    def _readable(self, client: Client) -> None:
        room = self._host.room()
        if room <= 0:
            self._reading = False
            for each in self._clients.values():
                self._loop.remove_reader(each.connection)
            return
        try:
            data = client.connection.recv(min(room, _READ_BYTES))
        except BlockingIOError:
            return
        except OSError:
            data = b""  # reset or timed out: it has left as one that closes has
        if not data:
            self._forget(client)
            return
        codec = self._codecs[client]
        rises = codec.rises
        payload, answer = codec.decode(data)
        if codec.rises != rises and not has_dtr(self._codecs.values(), but=codec):
            tell_opened(self._host)
        if answer:
            client.out.write(answer)
        if payload:
            self._last_codec = codec
            self._traffic.rx_bytes += len(payload)
            self._host.received(payload)

    def _forget(self, client: Client) -> None:
        if self._clients.pop(client.connection.fileno(), None) is client:
            client.close()
            if self._codecs.pop(client) is self._last_codec:
                self._last_codec = None

    def backlog(self) -> int:
        """Backlog of the fastest client: one that does not read must not hold up the others."""
        return min([client.out.backlog_bytes for client in self._clients.values()], default=0)

    def client_baud(self) -> int | None:
        """Baud of the client that sent last, where its codec has one."""
        return self._last_codec.baud if self._last_codec else None

    def stats(self) -> PortStats:
        return PortStats(
            clients=len(self._clients),
            turned_away=self._full.count + self._out_of_fds.count if self._acceptor else 0,
            **vars(self._traffic),
        )

    async def close(self) -> None:
        if self._look_timer is not None:
            self._look_timer.cancel()
        if self._acceptor is not None:
            self._full.close()
            self._out_of_fds.close()
            self._acceptor.close()
            self._acceptor = None
        for client in list(self._clients.values()):
            self._forget(client)
