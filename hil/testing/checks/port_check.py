"""Check of a kind of port: ``hil.vocab.ports.Port``."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

from hil.testing.checks.findings import CheckFailed, cuts, shown
from hil.testing.checks.port_ends import ALL_BYTES, CheckedHost, FileClient, Passage, PortClient
from hil.testing.checks.running_checks import Before, Wrong, findings_of, until, until_nothing_is
from hil.vocab.ports import Port

PATIENCE_S = 5.0
FLOOD_BYTES, FLOOD_PIECE = 16 << 20, 1 << 16
HELD_BYTES = 4 << 20
WRITE_S = 1.0
"""Maximum time for one write to a client that does not read: nothing of it waits for the client."""
STILL_S = 0.05
"""Time in which what must not happen would."""


def check_port(
    make: Callable[[Path], Port],
    client: Callable[[Port], PortClient] = FileClient.of,
    *,
    calls_out: bool = False,
    held_bytes: int = HELD_BYTES,
    patience_s: float = PATIENCE_S,
    only: str = "",
) -> None:
    """Check a kind of port. ``make``: makes one, not yet open, with a folder for what it shows; ``client``:
    opens it as a program does. ``calls_out``: the port is a client itself, and ``client`` whom it calls, who
    is always there. ``held_bytes``: maximum backlog for a client that does not read. ``patience_s``: time in
    which what has to happen does. ``only``: word of the one check to make, while a port is mended.

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
    - left: ``close`` leaves no file descriptor, task, thread or file, also when it is called again.

    Raises:
        CheckFailed: with all that is wrong.
    """
    found = asyncio.run(_PortCheck(make, client, calls_out, held_bytes, patience_s).findings(only))
    if found:
        raise CheckFailed("the port", found)


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

    async def findings(self, only: str) -> list[str]:
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
        return await findings_of({only: checks[only]} if only else checks)

    @asynccontextmanager
    async def _open(self) -> AsyncIterator[tuple[Port, CheckedHost]]:
        with TemporaryDirectory() as folder:
            port, host = self._make(Path(folder)), CheckedHost()
            await port.open(host)
            try:
                yield port, host
            finally:
                await port.close()
        if host.wrong:
            raise Wrong(host.wrong)

    @asynccontextmanager
    async def _served(self, port: Port, host: CheckedHost) -> AsyncIterator[Passage]:
        """Way between the host and a client that has come, and leaves at the end."""
        before = 0 if self._calls_out else port.stats().connects
        client = self._client(port)
        try:
            if not await self._until(lambda: port.stats().connects > before):
                raise Wrong(f"a client came, and {before} are counted that ever did")
            yield Passage(port, host, client, self._patience_s)
        finally:
            client.close()

    async def _until(self, condition: Callable[[], bool]) -> bool:
        return await until(condition, self._patience_s)

    async def _opened(self) -> None:
        async with self._open() as (port, host):
            if not port.address:
                raise Wrong("it has no address")
            async with self._served(port, host):
                if (clients := port.stats().clients) != 1:
                    raise Wrong(f"one client is there, {clients} are counted")

    async def _bytes(self) -> None:
        async with self._open() as (port, host), self._served(port, host) as way:
            await way.both_ways()

    async def _chunking(self) -> None:
        async with self._open() as (port, host), self._served(port, host) as way:
            for pieces in cuts(ALL_BYTES, Random(0)):
                host.got.clear()
                for piece in pieces:
                    await way.send(piece)
                    port.write(piece)
                await way.handed_over(ALL_BYTES)
                await way.read(ALL_BYTES)

    async def _silence(self) -> None:
        async with self._open() as (port, host):
            port.write(b"nobody hears it")
            if (unheard := port.stats().unheard_bytes) != len(b"nobody hears it"):
                raise Wrong(f"15 bytes were for nobody, {unheard} are counted as unheard")
            async with self._served(port, host) as way:
                await asyncio.sleep(STILL_S)
                if got := way.read_now():
                    raise Wrong(f"a client got {shown(got)}, which was sent before it came")
            if host.got:
                raise Wrong(f"nobody sent anything, and the device got {shown(bytes(host.got))}")

    async def _garbage(self) -> None:
        async with self._open() as (port, host):
            async with self._served(port, host) as way:
                await way.send(Random(1).randbytes(1 << 15))
                await asyncio.sleep(STILL_S)
            if host.wrong:
                raise Wrong(host.wrong)
            if self._calls_out:
                return
            async with self._served(port, host) as way:
                way.read_now()
                await way.both_ways()

    async def _reset(self) -> None:
        async with self._open() as (port, host):
            async with self._served(port, host) as way:
                port.write(b"for the first")
                await asyncio.sleep(STILL_S)
            if not await self._until(lambda: port.stats().clients == 0):
                raise Wrong("the only client has left, and is counted as there")
            async with self._served(port, host) as way:
                await asyncio.sleep(STILL_S)
                if got := way.read_now():
                    raise Wrong(f"the second client got {shown(got)}, which was for the first")
                await way.both_ways()

    async def _replay(self) -> None:
        seen = []
        for _ in range(2):
            async with self._open() as (port, host), self._served(port, host) as way:
                await way.both_ways()
                stats = port.stats()
                seen.append((bytes(host.got), stats.connects, stats.rx_bytes, stats.tx_bytes))
        if seen[0] != seen[1]:
            raise Wrong(f"the same again was {shown(seen[1])} after {shown(seen[0])}")
        _, connects, rx_bytes, _ = seen[0]
        if (connects, rx_bytes) != (1, len(ALL_BYTES)):
            raise Wrong(f"one client and 256 bytes of its are counted as {connects} and {rx_bytes}")

    async def _time(self) -> None:
        async with self._open() as (port, host), self._served(port, host):
            for _ in range(FLOOD_BYTES // FLOOD_PIECE):
                begin_s = time.monotonic()
                port.write(bytes(FLOOD_PIECE))
                if (took_s := time.monotonic() - begin_s) > WRITE_S:
                    raise Wrong(f"a write to a client that does not read took {took_s:.1f} s")

    async def _limits(self) -> None:
        async with self._open() as (port, host), self._served(port, host) as way:
            host.room_bytes = 10
            await way.send(ALL_BYTES)
            await self._until(lambda: len(host.got) >= 10)
            await asyncio.sleep(STILL_S)
            if host.wrong:
                raise Wrong(host.wrong)
            host.room_bytes = 1 << 30
            port.resume_reading()
            await way.handed_over(ALL_BYTES)
        async with self._open() as (port, host):
            async with self._served(port, host):
                for _ in range(FLOOD_BYTES // FLOOD_PIECE):
                    port.write(bytes(FLOOD_PIECE))
                    await asyncio.sleep(0)
                    if (waits := port.backlog()) > self._held_bytes:
                        raise Wrong(f"{waits} bytes wait for a client that does not read")
            if not await self._until(lambda: _accounted(port) == FLOOD_BYTES):
                known = _accounted(port)
                raise Wrong(f"{FLOOD_BYTES} bytes were for a client that left; {known} are counted")

    async def _left(self) -> None:
        with TemporaryDirectory() as name:
            before, folder = Before(), Path(name)
            port = self._make(folder)
            await port.open(CheckedHost())
            client = self._client(port)
            await asyncio.sleep(STILL_S)
            client.close()
            await port.close()
            await port.close()

            def left() -> str | None:
                files = sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))
                return before.left() or (f"files are left: {shown(files)}" if files else None)

            await until_nothing_is(left, self._patience_s)


def _accounted(port: Port) -> int:
    stats = port.stats()
    return stats.tx_bytes + stats.dropped_bytes + stats.unheard_bytes
