"""Ends of a port that is checked: the client before it, the device behind it, and the bytes between them."""

import os
import socket
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from hil.testing.checks.findings import shown
from hil.testing.checks.running_checks import Wrong, until
from hil.vocab.ports import Port

ALL_BYTES = bytes(range(256))


class PortClient(Protocol):
    """Program at a port. Nothing here waits."""

    def send(self, data: bytes) -> int:
        """Send as much as is taken now; answers how much."""

    def read(self) -> bytes:
        """Read what is there now."""

    def close(self) -> None:
        """Leave."""


class FileClient:
    """Program with an open file: a terminal, or a socket."""

    def __init__(self, fd: int) -> None:
        self._fd = fd
        os.set_blocking(fd, False)

    @classmethod
    def of(cls, port: Port) -> "FileClient":
        """Open a port whose address is a terminal's or a socket's path, or ``socket://``."""
        _, is_there, place = port.address.rpartition("://")
        if not is_there:
            if Path(place).is_socket():
                unix = socket.socket(socket.AF_UNIX)
                unix.connect(place)
                return cls(unix.detach())
            return cls(os.open(place, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK))
        host, _, number = place.partition("?")[0].rpartition(":")
        return cls(socket.create_connection((host.strip("[]"), int(number))).detach())

    def send(self, data: bytes) -> int:
        try:
            return os.write(self._fd, data)
        except BlockingIOError:
            return 0

    def read(self) -> bytes:
        data = b""
        with suppress(BlockingIOError):
            while chunk := os.read(self._fd, 65536):
                data += chunk
        return data

    def close(self) -> None:
        os.close(self._fd)


class CheckedHost:
    """``hil.vocab.ports.PortHost`` that notes what it gets, with as much room as it is given."""

    def __init__(self) -> None:
        self.got = bytearray()
        self.room_bytes = 1 << 30
        self.wrong: str | None = None

    def received(self, data: bytes) -> None:
        if not data:
            self.wrong = "it hands over no bytes at all"
        if len(data) > self.room_bytes:
            self.wrong = f"it hands over {len(data)} bytes where there is room for {self.room_bytes}"
        self.room_bytes -= len(data)
        self.got += data

    def room(self) -> int:
        return max(self.room_bytes, 0)

    def drained(self) -> None:
        """Nobody waits for it."""

    def client_left(self, baud: int | None) -> None:
        """The counts say so."""

    def port_failed(self, reason: str) -> None:
        self.wrong = f"it gave up: {reason}"


class Passage:
    """Way of bytes through a port, between a client of it and its host. Nothing waits longer than
    ``patience_s``; what does not pass raises ``Wrong``."""

    def __init__(self, port: Port, host: CheckedHost, client: PortClient, patience_s: float) -> None:
        self._port, self._host, self._client = port, host, client
        self._patience_s = patience_s

    async def send(self, data: bytes) -> None:
        """Let the client send."""
        left = data

        def sent() -> bool:
            nonlocal left
            left = left[self._client.send(left[:4096]) :]
            return not left

        if not await until(sent, self._patience_s):
            raise Wrong(f"the client is held up: {len(left)} of {len(data)} bytes are not read")

    async def handed_over(self, data: bytes) -> None:
        """Wait until the host has got these bytes."""
        host = self._host
        await until(lambda: len(host.got) >= len(data), self._patience_s)
        if bytes(host.got) != data:
            raise Wrong(f"the client sent {shown(data)}, and the device got {shown(bytes(host.got))}")

    async def read(self, data: bytes) -> None:
        """Wait until the client has got these bytes."""
        got = bytearray()

        def is_whole() -> bool:
            got.extend(self._client.read())
            return len(got) >= len(data)

        await until(is_whole, self._patience_s)
        if bytes(got) != data:
            raise Wrong(f"the device sent {shown(data)}, and the client got {shown(bytes(got))}")

    def read_now(self) -> bytes:
        """Read what the client has got by now."""
        return self._client.read()

    async def both_ways(self) -> None:
        """Let all values of a byte pass both ways."""
        self._host.got.clear()
        await self.send(ALL_BYTES)
        await self.handed_over(ALL_BYTES)
        self._port.write(ALL_BYTES)
        await self.read(ALL_BYTES)
