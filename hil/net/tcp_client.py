"""One connection: its socket and what waits to be sent to it."""

import asyncio
import socket
from collections.abc import Callable

from hil.net.traffic import Outgoing, Traffic

KEEP_ALIVE = {"TCP_KEEPIDLE": 10, "TCP_KEEPINTVL": 5, "TCP_KEEPCNT": 3}
"""Silence and time between probes in seconds, number of probes: who answers none has vanished, after 25 s."""
_TRIES = 7
"""The same for one that data waits for: sent again after 0.2 s, 0.4 s and so on, 25 s in all."""
_TCP_INFO_BYTES = 4  # state, ca_state, retransmits, probes: the begin of struct tcp_info, linux/tcp.h


class Client:
    """``out`` is what is sent to it; ``drained`` and ``traffic`` as there.

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
        """Whether its computer acknowledges nothing any more; that of a client that does not read, does."""
        info = self.connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _TCP_INFO_BYTES)
        retransmits, probes = info[2:4]
        return retransmits >= _TRIES or probes >= _TRIES

    def close(self) -> None:
        self.out.stop()
        self._loop.remove_reader(self.connection)
        self.connection.close()
