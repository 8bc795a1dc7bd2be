"""A port in memory."""

import asyncio

from hil.vocab.ports import PortHost, PortStats


class MemoryPort:
    """``hil.vocab.ports.Port`` whose client is the test."""

    address = "memory"

    def __init__(self) -> None:
        self.sent: asyncio.Queue[bytes] = asyncio.Queue()
        self.is_open = False

    async def open(self, host: PortHost) -> None:
        self.host, self.is_open = host, True

    def write(self, data: bytes) -> None:
        self.sent.put_nowait(data)

    def resume_reading(self) -> None: ...

    def backlog(self) -> int:
        return 0

    def client_baud(self) -> int | None:
        return None

    def stats(self) -> PortStats:
        return PortStats(1, 1, 0, 0, 0, 0)

    async def close(self) -> None:
        self.is_open = False
