"""Connection to a door of Modbus TCP in memory: the door's transport, and the client's end of it."""

import asyncio
from collections.abc import Callable
from typing import Any

from hil.testing.doors.door_time import DoorTime


class MemoryConnection(asyncio.Transport):
    """Connection between a client and the door; each message takes its time on the way. ``certificate``: what
    the client shows of it, DER; ``heard``: called with what the door sends, and with nothing when the door
    has hung up."""

    def __init__(self, time: DoorTime, certificate: bytes | None, heard: Callable[[bytes], None]) -> None:
        super().__init__({"ssl_object": self})
        self._time, self._certificate, self._heard = time, certificate, heard
        self._protocol: asyncio.Protocol | None = None
        self._is_closing = self._is_paused = False
        self._unread = bytearray()

    def getpeercert(self, binary_form: bool = False) -> bytes | None:
        """Certificate that the client has shown, as ``ssl.SSLObject`` answers it."""
        return self._certificate

    def occupy(self, protocol: asyncio.Protocol) -> None:
        """Put the door's side behind it, which may hang up at once."""
        self._protocol = protocol
        protocol.connection_made(self)

    # ---- the client's end ----

    def send(self, data: bytes) -> None:
        """Send to the door."""
        self._time.later(self._arrive, bytes(data))

    def hang_up(self) -> None:
        """Close the client's end: what it has sent still arrives."""
        self._heard = _ignore
        self._time.later(self._lose)

    def _arrive(self, data: bytes) -> None:
        if not self._is_closing:
            self._unread += data
            self._read()

    def _read(self) -> None:
        if self._unread and not self._is_paused and not self._is_closing and self._protocol:
            data = bytes(self._unread)
            self._unread.clear()
            self._protocol.data_received(data)

    # ---- asyncio.Transport, the door's end ----

    def write(self, data: Any) -> None:
        if not self._is_closing:
            self._time.later(self._tell, bytes(data))

    def _tell(self, data: bytes) -> None:
        self._heard(data)  # that of now: the client may have hung up meanwhile

    def is_closing(self) -> bool:
        return self._is_closing

    def close(self) -> None:
        if not self._is_closing:
            self._time.later(self._tell, b"")
            self._lose()

    abort = close

    def _lose(self) -> None:
        if not self._is_closing:
            self._is_closing = True
            if self._protocol and not self._time.loop.is_closed():
                self._time.loop.call_soon(self._protocol.connection_lost, None)

    def pause_reading(self) -> None:
        self._is_paused = True

    def resume_reading(self) -> None:
        if self._is_paused:
            self._is_paused = False
            self._time.loop.call_soon(self._read)


def _ignore(data: bytes) -> None:
    """Hear nothing any more."""
