"""Counters of a port, and the queue of what its clients have not taken yet."""

from collections.abc import Callable
from dataclasses import field
from typing import TYPE_CHECKING

from hil.vocab.late_dataclass import dataclass

if TYPE_CHECKING:
    import asyncio

QUEUE_BYTES = 4 * 1024 * 1024  # thirty answers of the longest kind (q of a Mechaduino: 126 kB)


@dataclass
class Traffic:
    """Counters of ``hil.vocab.ports.PortStats``, since the port was opened."""

    connects: int = 0
    rx_bytes: int = 0
    tx_bytes: int = 0
    dropped_bytes: int = 0
    unheard_bytes: int = 0


@dataclass(eq=False)
class Outgoing:
    """Queue of bytes for a file descriptor: sent at once, or queued while its reader is slow.

    ``traffic`` counts each byte as sent or dropped, once. ``drained`` is called each time ``backlog_bytes``
    goes back to 0, perhaps in the middle of a ``write``; ``died`` once, when ``send`` has failed: from then
    on all is dropped.
    """

    fd: int
    send: Callable[[bytes | bytearray], int]
    loop: "asyncio.AbstractEventLoop"
    traffic: Traffic
    drained: Callable[[], None]
    died: Callable[[OSError], None]
    queue_bytes: int = QUEUE_BYTES
    look: Callable[[], None] = lambda: None
    """Called before queued bytes are sent; it may call ``stop`` or ``discard``."""
    _queue: bytearray = field(default_factory=bytearray, init=False)
    _is_stopped: bool = field(default=False, init=False)

    @property
    def backlog_bytes(self) -> int:
        return len(self._queue)

    def write(self, data: bytes) -> None:
        """Send or queue bytes. Never blocks; what finds no room in the queue is dropped."""
        sent = 0 if self._queue else self._send(data)
        if sent == len(data):
            return
        fits = 0 if self._is_stopped else self.queue_bytes - len(self._queue)
        waiting = data[sent : sent + fits]
        self.traffic.dropped_bytes += len(data) - sent - len(waiting)
        if waiting and not self._queue:
            self.loop.add_writer(self.fd, self._writable)
        self._queue += waiting

    def _writable(self) -> None:
        self.look()
        if self._queue:
            del self._queue[: self._send(self._queue)]
            if not self._queue and not self._is_stopped:
                self._leave()

    def _send(self, data: bytes | bytearray) -> int:
        if self._is_stopped:
            return 0
        try:
            sent = self.send(data)
        except BlockingIOError:
            return 0
        except OSError as error:
            self.stop()
            self.died(error)
            return 0
        self.traffic.tx_bytes += sent
        return sent

    def _leave(self) -> None:
        self.loop.remove_writer(self.fd)
        self.drained()

    def discard(self) -> None:
        """Drop what waits."""
        if self._queue:
            self.traffic.dropped_bytes += len(self._queue)
            self._queue.clear()
            self._leave()

    def stop(self) -> None:
        """Drop what waits and all that comes."""
        self._is_stopped = True
        self.discard()
