"""A disk with a volatile write cache whose power can be cut at any request: a server of the NBD protocol.

Data written since the last flush are in the cache. When the power goes, each sector of it is on the medium in
one of the versions that it had, or as before, by chance: a real drive writes its cache in any order. Data for
which a flush was answered are on the medium.

Protocol: https://github.com/NetworkBlockDevice/nbd/blob/master/doc/proto.md
"""

import random
import socket
import struct
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

SECTOR = 512
_OPTION = struct.Struct(">8sII")
_REPLY = struct.Struct(">QIII")
_REQUEST = struct.Struct(">IHHQQI")
_ANSWER = struct.Struct(">IIQ")
_MAGIC, _HAVE_OPTION, _OPTION_REPLY = b"NBDMAGIC", b"IHAVEOPT", 0x3E889045565A9
_EXPORT_NAME, _ABORT, _INFO, _GO = 1, 2, 6, 7
_ACK, _IS_INFO, _UNSUPPORTED = 1, 3, 0x80000001
_HAS_FLAGS, _SEND_FLUSH, _SEND_FUA = 1, 4, 8
_READ, _WRITE, _DISCONNECT, _FLUSH = 0, 1, 2, 3
_FUA = 1
_EINVAL = 22


class VolatileDisk:
    """Listens on a unix socket; one client at a time."""

    def __init__(self, image: bytes, path: Path, chance: random.Random) -> None:
        self.path = path
        self.requests = 0
        """Number of writes and flushes so far."""
        self._medium = bytearray(image)
        self._cache: dict[int, list[bytes]] = {}
        self._chance = chance
        self._changed = threading.Condition()
        self._on: Callable[[], None] | None = None
        self._on_at = 0
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(path))
        self._listener.listen(1)
        self._thread = threading.Thread(target=self._serve, name="disk", daemon=True)
        self._thread.start()

    def cut(self, requests: int, timeout_s: float, look: Callable[[], int]) -> tuple[bytes, int]:
        """Content of the medium after a power cut when so many more writes and flushes have come.

        With it what ``look`` said at that moment, before the next request. The disk itself goes on.

        Raises:
            TimeoutError: they did not come.
        """
        found: list[tuple[bytes, int]] = []

        def take() -> None:
            said = look()
            found.append((self._after_cut(), said))

        with self._changed:
            self._on, self._on_at = take, self.requests + requests
            if not self._changed.wait_for(lambda: found, timeout_s):
                self._on = None
                raise TimeoutError(f"not {requests} requests within {timeout_s:g} s")
        return found[0]

    def power_cut(self) -> None:
        """Drop what is in the cache, but for what chance leaves on the medium."""
        with self._changed:
            self._medium[:] = self._after_cut()
            self._cache.clear()

    def _after_cut(self) -> bytes:
        image, kept = bytearray(self._medium), self._chance.choice((0.0, 0.5, 0.9, 1.0))
        for sector, versions in self._cache.items():
            if self._chance.random() < kept:
                image[sector * SECTOR : (sector + 1) * SECTOR] = self._chance.choice(versions)
        return bytes(image)

    def close(self) -> None:
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._thread.join(10)

    def _serve(self) -> None:
        with suppress(OSError):  # the listener is closed: the end
            while True:
                client, _ = self._listener.accept()
                with client, suppress(EOFError, ConnectionError):
                    if self._negotiated(client):
                        while self._answered(client):
                            pass

    def _negotiated(self, client: socket.socket) -> bool:
        client.sendall(_MAGIC + _HAVE_OPTION + struct.pack(">H", 3))  # fixed newstyle, no zeroes
        _take(client, 4)
        shape = struct.pack(">QH", len(self._medium), _HAS_FLAGS | _SEND_FLUSH | _SEND_FUA)
        while True:
            _, option, length = _OPTION.unpack(_take(client, _OPTION.size))
            _take(client, length)
            if option == _EXPORT_NAME:
                client.sendall(shape)
                return True
            if option in (_GO, _INFO):
                info = struct.pack(">H", 0) + shape
                client.sendall(_REPLY.pack(_OPTION_REPLY, option, _IS_INFO, len(info)) + info)
            known = option in (_GO, _INFO, _ABORT)
            client.sendall(_REPLY.pack(_OPTION_REPLY, option, _ACK if known else _UNSUPPORTED, 0))
            if option in (_GO, _ABORT):
                return option == _GO

    def _answered(self, client: socket.socket) -> bool:
        _, flags, kind, cookie, offset, length = _REQUEST.unpack(_take(client, _REQUEST.size))
        if kind == _DISCONNECT:
            return False
        written = _take(client, length) if kind == _WRITE else b""
        error, data = 0, b""
        with self._changed:
            if kind in (_WRITE, _FLUSH):
                self._cut_if_due()
                self.requests += 1
            if kind == _READ:
                data = self._read(offset, length)
            elif kind == _WRITE:
                self._write(offset, written, durable=bool(flags & _FUA))
            elif kind == _FLUSH:
                self._flush()
            else:
                error = _EINVAL
        client.sendall(_ANSWER.pack(0x67446698, error, cookie) + data)
        return True

    def _cut_if_due(self) -> None:
        if self._on and self.requests >= self._on_at:
            self._on()
            self._on = None
            self._changed.notify_all()

    def _read(self, offset: int, length: int) -> bytes:
        data = bytearray(self._medium[offset : offset + length])
        for sector in range(offset // SECTOR, (offset + length) // SECTOR):
            if versions := self._cache.get(sector):
                at = sector * SECTOR - offset
                data[at : at + SECTOR] = versions[-1]
        return bytes(data)

    def _write(self, offset: int, data: bytes, durable: bool) -> None:
        for at in range(0, len(data), SECTOR):
            sector, written = (offset + at) // SECTOR, data[at : at + SECTOR]
            if durable:
                self._cache.pop(sector, None)
                self._medium[sector * SECTOR : (sector + 1) * SECTOR] = written
            else:
                self._cache.setdefault(sector, []).append(written)

    def _flush(self) -> None:
        for sector, versions in self._cache.items():
            self._medium[sector * SECTOR : (sector + 1) * SECTOR] = versions[-1]
        self._cache.clear()


def _take(client: socket.socket, length: int) -> bytes:
    data = b""
    while len(data) < length:
        if not (piece := client.recv(length - len(data))):
            raise EOFError
        data += piece
    return data
