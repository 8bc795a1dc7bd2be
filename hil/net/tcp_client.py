"""One connection: its socket and what waits to be sent to it."""

import asyncio
import socket
from collections.abc import Callable

KEEP_ALIVE = {"TCP_KEEPIDLE": 10, "TCP_KEEPINTVL": 5, "TCP_KEEPCNT": 3}
"""Silence and time between probes in seconds, number of probes: who answers none has vanished, after 25 s."""
_TRIES = 7
"""The same for one that data waits for: sent again after 0.2 s, 0.4 s and so on, 25 s in all."""
_TCP_INFO_BYTES = 4  # state, ca_state, retransmits, probes: the begin of struct tcp_info, linux/tcp.h
QUEUE_BYTES = 4 * 1024 * 1024  # thirty answers of the longest kind (q of a Mechaduino: 126 kB)


class Client:
    """``count(tx_bytes, dropped_bytes)`` is told the fate of each byte given to ``write``, once;
    ``drained`` is called each time ``backlog_bytes`` goes back to 0, perhaps in the middle of a ``write``.

    The owner reads ``connection`` and calls ``close`` when it ends, or when ``died`` is called, from the
    event loop: what such a client has sent and was not read yet is void. Until then a dead connection drops.
    """

    def __init__(
        self,
        connection: socket.socket,
        loop: asyncio.AbstractEventLoop,
        count: Callable[[int, int], None],
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
        self._count = count
        self._drained = drained
        self._died = died
        self._queue = bytearray()
        self._dead = False

    @property
    def backlog_bytes(self) -> int:
        return len(self._queue)

    def write(self, data: bytes) -> None:
        sent = 0 if self._queue else self._send(data)
        fits = 0 if self._dead else QUEUE_BYTES - len(self._queue)
        waiting = data[sent : sent + fits]
        self._count(0, len(data) - sent - len(waiting))
        if waiting and not self._queue:
            self._loop.add_writer(self.connection, self._writable)
        self._queue += waiting

    def has_vanished(self) -> bool:
        """Its computer acknowledges nothing any more; that of a client which only does not read, does."""
        info = self.connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _TCP_INFO_BYTES)
        retransmits, probes = info[2:4]
        return retransmits >= _TRIES or probes >= _TRIES

    def _writable(self) -> None:
        del self._queue[: self._send(self._queue)]
        if self._dead:
            self._discard_queue()
        elif not self._queue:
            self._loop.remove_writer(self.connection)
            self._drained()

    def _send(self, data: bytes | bytearray) -> int:
        if self._dead:
            return 0
        try:
            sent = self.connection.send(data)
        except BlockingIOError:
            return 0
        except OSError:
            self._dead = True
            self._loop.call_soon(self._died, self)
            return 0
        self._count(sent, 0)
        return sent

    def _discard_queue(self) -> None:
        if self._queue:
            self._loop.remove_writer(self.connection)
            self._count(0, len(self._queue))
            self._queue.clear()
            self._drained()

    def close(self) -> None:
        self._discard_queue()
        self._loop.remove_reader(self.connection)
        self.connection.close()
