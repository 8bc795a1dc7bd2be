"""Kit for tests of kinds of ports: a host that records, and clients that read without blocking."""

import asyncio
import gc
import os
import select
import time
from collections.abc import Awaitable, Callable

from hil.vocab.ports import Port

DEADLINE_S = 20.0


class RecordingHost:
    """``PortHost`` that keeps what it gets, has as much room as it is told, and may answer."""

    def __init__(self, port: Port) -> None:
        self.port = port
        self.got = bytearray()
        self.bauds: list[int | None] = []
        self.room_bytes = 1 << 30
        self.failures: list[str] = []
        self.drains = 0
        self.left: list[int | None] = []
        """Bauds of last clients, as they left."""
        self.openings: list[int] = []
        """Numbers of bytes that had come when the line was opened."""
        self.answer: Callable[[bytes], bytes] = lambda data: b""

    def received(self, data: bytes) -> None:
        assert 0 < len(data) <= self.room_bytes
        self.room_bytes -= len(data)
        self.got += data
        self.bauds.append(self.port.client_baud())
        if reply := self.answer(data):
            self.port.write(reply)

    def room(self) -> int:
        return self.room_bytes

    def drained(self) -> None:
        assert self.port.backlog() == 0
        self.drains += 1

    def client_left(self, baud: int | None) -> None:
        self.left.append(baud)

    def line_opened(self) -> None:
        self.openings.append(len(self.got))

    def port_failed(self, reason: str) -> None:
        self.failures.append(reason)


Scenario = Callable[[Port, RecordingHost], Awaitable[None]]


def run_port(port: Port, scenario: Scenario) -> None:
    """Open the port, run the scenario on an event loop, close it; the port must not have failed."""

    async def main() -> None:
        host = RecordingHost(port)
        await port.open(host)
        try:
            await scenario(port, host)
            assert host.failures == []
        finally:
            await port.close()

    asyncio.run(main())


async def until(condition: Callable[[], bool]) -> None:
    """Let the event loop run until the condition holds; fails after ``DEADLINE_S``."""
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, "the condition did not come true"
        await asyncio.sleep(0)


def read_now(fd: int) -> bytes:
    """Read what a file descriptor has at this moment."""
    data = b""
    while select.select([fd], [], [], 0)[0] and (chunk := os.read(fd, 65536)):
        data += chunk
    return data


async def read_exactly(fd: int, size: int) -> bytes:
    """Read until at least ``size`` bytes have come."""
    data = bytearray()

    def complete() -> bool:
        data.extend(read_now(fd))
        return len(data) >= size

    await until(complete)
    return bytes(data)


def open_fds() -> list[str]:
    """List this process's file descriptors, after garbage that held some is collected."""
    gc.collect()
    return sorted(os.listdir("/proc/self/fd"))


def accounted(port: Port) -> int:
    """Number of bytes of the device whose fate is known."""
    stats = port.stats()
    return stats.tx_bytes + stats.dropped_bytes + stats.unheard_bytes
