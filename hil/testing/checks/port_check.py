"""Check of a kind of port: ``hil.vocab.ports.Port``."""

import asyncio
import os
import socket
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, Protocol

from hil.testing.checks.findings import CheckFailed, cuts, descriptors, raised, shown
from hil.vocab.ports import Port

PATIENCE_S = 5.0
ALL_BYTES = bytes(range(256))
FLOOD_BYTES, FLOOD_PIECE = 16 << 20, 1 << 16
HELD_BYTES = 4 << 20
WRITE_S = 1.0
"""Most time for one write to a client that does not read: nothing of it waits for the client."""
STILL_S = 0.05
"""Time in which what must not happen would."""


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


def check_port(
    make: Callable[[Path], Port],
    client: Callable[[Port], PortClient] = FileClient.of,
    *,
    calls_out: bool = False,
    held_bytes: int = HELD_BYTES,
    patience_s: float = PATIENCE_S,
) -> None:
    """Check a kind of port. ``make``: makes one, not yet open, with a folder for what it shows; ``client``:
    opens it as a program does. ``calls_out``: the port is a client itself, and ``client`` whom it calls, who
    is always there. ``held_bytes``: maximum backlog for a client that does not read. ``patience_s``: time in
    which what has to happen does.

    - opened: it has an address, and a client that comes is counted.
    - bytes: all 256 values pass both ways, in order.
    - chunking: they do however they are cut.
    - silence: bytes for nobody are counted as unheard, and no later client gets them; nothing comes from
      nobody.
    - garbage: whatever a client sends, the port goes on.
    - reset: after a client has left, the next is served, and gets nothing of the other's.
    - replay: the same again has the same bytes and counts.
    - time: no write waits for a client that does not read.
    - limits: never more than ``PortHost.room()`` is handed over, nothing is lost while there is none, and no
      more than ``held_bytes`` wait for a client; what is lost is counted.
    - left: ``close`` leaves no file descriptor, task or file, also when it is called again.

    Raises:
        CheckFailed: with all that is wrong.
    """
    found = asyncio.run(_PortCheck(make, client, calls_out, held_bytes, patience_s).all())
    if found:
        raise CheckFailed("the port", found)


class _Wrong(Exception):
    """What is wrong, if something is."""


class _Host:
    """Device behind the port, with as much room as it is given."""

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


class _PortCheck:
    def __init__(
        self,
        make: Callable[[Path], Port],
        client: Callable[[Port], PortClient],
        calls_out: bool,
        held_bytes: int,
        patience_s: float,
    ) -> None:
        self._make, self._client, self._calls_out = make, client, calls_out
        self._held_bytes, self._patience_s = held_bytes, patience_s

    async def all(self) -> list[str]:
        checks = {
            "opened": self._opened,
            "bytes": self._bytes,
            "chunking": self._chunking,
            "silence": self._silence,
            "garbage": self._garbage,
            "reset": self._reset,
            "replay": self._replay,
            "time": self._time,
            "limits": self._limits,
            "left": self._left,
        }
        if self._calls_out:  # nobody leaves or comes
            checks = {word: check for word, check in checks.items() if word not in ("silence", "reset")}
        found = [(word, await self._of(check)) for word, check in checks.items()]
        return [f"{word}: {wrong}" for word, wrong in found if wrong is not None]

    async def _of(self, check: Callable[[], Awaitable[None]]) -> str | None:
        errors: list[str] = []
        loop = asyncio.get_running_loop()
        loop.set_exception_handler(lambda _, about: errors.append(_error_of(about)))
        try:
            await check()
            if errors:
                return errors[0]
        except _Wrong as wrong:
            return str(wrong)
        except Exception as error:  # theirs: it is what the check is for
            return f"it raised {raised(error)}"
        return None

    # ---- what each check is made of ----

    @asynccontextmanager
    async def _open(self) -> AsyncIterator[tuple[Port, _Host]]:
        with TemporaryDirectory() as folder:
            port, host = self._make(Path(folder)), _Host()
            await port.open(host)
            try:
                yield port, host
            finally:
                await port.close()
        if host.wrong:
            raise _Wrong(host.wrong)

    @asynccontextmanager
    async def _served(self, port: Port) -> AsyncIterator[PortClient]:
        """A client that has come, and leaves at the end."""
        before = 0 if self._calls_out else port.stats().connects
        client = self._client(port)
        try:
            if not await self._until(lambda: port.stats().connects > before):
                raise _Wrong(f"a client came, and {before} are counted that ever did")
            yield client
        finally:
            client.close()

    async def _until(self, condition: Callable[[], bool]) -> bool:
        end_s = time.monotonic() + self._patience_s
        while not condition():
            if time.monotonic() > end_s:
                return False
            await asyncio.sleep(0.001)
        return True

    async def _sent(self, client: PortClient, data: bytes) -> None:
        left = data

        def sent() -> bool:
            nonlocal left
            left = left[client.send(left[:4096]) :]
            return not left

        if not await self._until(sent):
            raise _Wrong(f"the client is held up: {len(left)} of {len(data)} bytes are not read")

    async def _handed_over(self, host: _Host, data: bytes) -> None:
        """Wait until the device has got these bytes."""
        await self._until(lambda: len(host.got) >= len(data))
        if bytes(host.got) != data:
            raise _Wrong(f"the client sent {shown(data)}, and the device got {shown(bytes(host.got))}")

    async def _read(self, client: PortClient, data: bytes) -> None:
        """Wait until the client has got these bytes."""
        got = bytearray()

        def is_whole() -> bool:
            got.extend(client.read())
            return len(got) >= len(data)

        await self._until(is_whole)
        if bytes(got) != data:
            raise _Wrong(f"the device sent {shown(data)}, and the client got {shown(bytes(got))}")

    async def _both_ways(self, port: Port, host: _Host, client: PortClient) -> None:
        host.got.clear()
        await self._sent(client, ALL_BYTES)
        await self._handed_over(host, ALL_BYTES)
        port.write(ALL_BYTES)
        await self._read(client, ALL_BYTES)

    # ---- the checks ----

    async def _opened(self) -> None:
        async with self._open() as (port, _):
            if not port.address:
                raise _Wrong("it has no address")
            async with self._served(port):
                if (clients := port.stats().clients) != 1:
                    raise _Wrong(f"one client is there, {clients} are counted")

    async def _bytes(self) -> None:
        async with self._open() as (port, host), self._served(port) as client:
            await self._both_ways(port, host, client)

    async def _chunking(self) -> None:
        async with self._open() as (port, host), self._served(port) as client:
            for pieces in cuts(ALL_BYTES, Random(0)):
                host.got.clear()
                for piece in pieces:
                    await self._sent(client, piece)
                    port.write(piece)
                await self._handed_over(host, ALL_BYTES)
                await self._read(client, ALL_BYTES)

    async def _silence(self) -> None:
        async with self._open() as (port, host):
            port.write(b"nobody hears it")
            if (unheard := port.stats().unheard_bytes) != len(b"nobody hears it"):
                raise _Wrong(f"15 bytes were for nobody, {unheard} are counted as unheard")
            async with self._served(port) as client:
                await asyncio.sleep(STILL_S)
                if got := client.read():
                    raise _Wrong(f"a client got {shown(got)}, which was sent before it came")
            if host.got:
                raise _Wrong(f"nobody sent anything, and the device got {shown(bytes(host.got))}")

    async def _garbage(self) -> None:
        async with self._open() as (port, host):
            async with self._served(port) as client:
                await self._sent(client, Random(1).randbytes(1 << 15))
                await asyncio.sleep(STILL_S)
            if host.wrong:
                raise _Wrong(host.wrong)
            if self._calls_out:
                return
            async with self._served(port) as client:
                client.read()
                await self._both_ways(port, host, client)

    async def _reset(self) -> None:
        async with self._open() as (port, host):
            async with self._served(port) as client:
                port.write(b"for the first")
                await asyncio.sleep(STILL_S)
            if not await self._until(lambda: port.stats().clients == 0):
                raise _Wrong("the only client has left, and is counted as there")
            async with self._served(port) as client:
                await asyncio.sleep(STILL_S)
                if got := client.read():
                    raise _Wrong(f"the second client got {shown(got)}, which was for the first")
                await self._both_ways(port, host, client)

    async def _replay(self) -> None:
        seen = []
        for _ in range(2):
            async with self._open() as (port, host), self._served(port) as client:
                await self._both_ways(port, host, client)
                stats = port.stats()
                seen.append((bytes(host.got), stats.connects, stats.rx_bytes, stats.tx_bytes))
        if seen[0] != seen[1]:
            raise _Wrong(f"the same again was {shown(seen[1])} after {shown(seen[0])}")
        _, connects, rx_bytes, _ = seen[0]
        if (connects, rx_bytes) != (1, len(ALL_BYTES)):
            raise _Wrong(f"one client and 256 bytes of its are counted as {connects} and {rx_bytes}")

    async def _time(self) -> None:
        async with self._open() as (port, _), self._served(port):
            for _ in range(FLOOD_BYTES // FLOOD_PIECE):
                begin_s = time.monotonic()
                port.write(bytes(FLOOD_PIECE))
                if (took_s := time.monotonic() - begin_s) > WRITE_S:
                    raise _Wrong(f"a write to a client that does not read took {took_s:.1f} s")

    async def _limits(self) -> None:
        async with self._open() as (port, host), self._served(port) as client:
            host.room_bytes = 10
            await self._sent(client, ALL_BYTES)
            await self._until(lambda: len(host.got) >= 10)
            await asyncio.sleep(STILL_S)
            if host.wrong:
                raise _Wrong(host.wrong)
            host.room_bytes = 1 << 30
            port.resume_reading()
            await self._handed_over(host, ALL_BYTES)
        async with self._open() as (port, host):
            async with self._served(port):
                for _ in range(FLOOD_BYTES // FLOOD_PIECE):
                    port.write(bytes(FLOOD_PIECE))
                    await asyncio.sleep(0)
                    if (waits := port.backlog()) > self._held_bytes:
                        raise _Wrong(f"{waits} bytes wait for a client that does not read")
            if not await self._until(lambda: _accounted(port) == FLOOD_BYTES):
                known = _accounted(port)
                raise _Wrong(f"{FLOOD_BYTES} bytes were for a client that left; {known} are counted")

    async def _left(self) -> None:
        with TemporaryDirectory() as folder:
            before, tasks = descriptors(), asyncio.all_tasks()
            port = self._make(Path(folder))
            await port.open(_Host())
            client = self._client(port)
            await asyncio.sleep(STILL_S)
            client.close()
            await port.close()
            await port.close()
            await self._until(lambda: not self._rest(Path(folder), before, tasks))
            if wrong := self._rest(Path(folder), before, tasks):
                raise _Wrong(wrong)

    @staticmethod
    def _rest(folder: Path, before: int, tasks: set[asyncio.Task[Any]]) -> str | None:
        """What a closed port has left."""
        if left := asyncio.all_tasks() - tasks:
            return f"tasks are left: {shown([task.get_name() for task in left])}"
        if files := sorted(str(path.relative_to(folder)) for path in folder.rglob("*")):
            return f"files are left: {shown(files)}"
        if (more := descriptors() - before) > 0:
            return f"{more} file descriptors are left open"
        return None


def _error_of(about: dict[str, Any]) -> str:
    """An error that a callback or a task of theirs raised."""
    error = about.get("exception")
    return f"it raised {raised(error)}" if error else str(about["message"])


def _accounted(port: Port) -> int:
    stats = port.stats()
    return stats.tx_bytes + stats.dropped_bytes + stats.unheard_bytes
