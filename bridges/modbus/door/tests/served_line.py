"""A serial line in simulated time: a door at a port in memory, and its master."""

import asyncio
import struct
from collections.abc import Awaitable, Callable

from served_door import LOOK, READ, R
from simulated_loop import Simulated

from bridges.modbus.door.door_options import Options
from bridges.modbus.door.modbus_bridge import ModbusBridge
from bridges.modbus.protocol.frame import encode
from hil.testing import RecordingDesk
from hil.vocab.ports import PortHost, PortStats

GOOD = encode(1, 4, b"\4" + struct.pack(">f", R))
PATIENCE_S = 60.0


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


class Line:
    def __init__(self, bridge: ModbusBridge, desk: RecordingDesk, port: MemoryPort) -> None:
        self.bridge, self.desk, self.port = bridge, desk, port

    async def ask(self, frame: bytes) -> bytes:
        self.port.host.received(frame)
        async with asyncio.timeout(PATIENCE_S):
            return await self.port.sent.get()

    async def is_silent_after(self, frame: bytes) -> bool:
        """True if what comes next is the answer to a good request."""
        self.port.host.received(frame)
        while self.bridge.status()["lines"]["memory"]["frames"] + self.errors < self.heard + 1:
            await asyncio.sleep(0.001)
        await asyncio.sleep(0.005)
        return self.port.sent.empty() and await self.ask(good(READ)) == GOOD

    heard = 0

    @property
    def errors(self) -> int:
        return int(self.bridge.status()["lines"]["memory"]["errors"])


def good(pdu: bytes, address: int = 1) -> bytes:
    return encode(address, pdu[0], pdu[1:])


def on_line(
    use: Callable[[Line], Awaitable[None]], at: RecordingDesk | None = None, **options: object
) -> None:
    async def main() -> None:
        desk, port = at or RecordingDesk({"look": LOOK}), MemoryPort()
        line = {"path": "plc", "baud": 115200, **options}
        bridge = ModbusBridge(Options.model_validate({"listen": "127.0.0.1:0", "rtu": [line]}), desk)
        bridge.take_ports([port])
        await bridge.open()
        try:
            assert bridge.status()["listen"][1] == "memory"
            await use(Line(bridge, desk, port))
        finally:
            await bridge.close()
        assert not port.is_open

    with asyncio.Runner(loop_factory=Simulated) as runner:
        runner.run(main())
