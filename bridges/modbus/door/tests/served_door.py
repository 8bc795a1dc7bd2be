"""A door at a desk that notes what it is asked, and a client that sends it any bytes."""

import asyncio
import struct
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

from bridges.modbus.door.door_options import Options
from bridges.modbus.door.modbus_bridge import ModbusBridge
from hil.testing import RecordingDesk
from hil.vocab.axis import AxisState
from hil.vocab.desk_protocol import AxisLook
from hil.vocab.time import SimTimeNs

PATIENCE_S = 60.0
"""Time that a test of a computer with much other work may take for one answer."""
NOTHING_S = 0.2
WAVE = bytes.fromhex("05 0000 ff00")
READ = bytes.fromhex("04 03e8 0002")
R = 1.5
LOOK = AxisLook(struct.pack("<f4x", R), AxisState(SimTimeNs(7), 1.0, 0.5, False, False), None)


def desk() -> RecordingDesk:
    return RecordingDesk({"look": LOOK})


def packet(pdu: bytes, transaction: int = 1, unit: int = 1, protocol: int = 0) -> bytes:
    return struct.pack(">HHHB", transaction, protocol, len(pdu) + 1, unit) + pdu


@dataclass
class RawClient:
    reader: asyncio.StreamReader
    writer: asyncio.StreamWriter

    async def send(self, data: bytes) -> None:
        self.writer.write(data)
        await self.writer.drain()

    async def answer(self) -> tuple[int, int, bytes]:
        """Transaction, unit and PDU of the next answer."""
        async with asyncio.timeout(PATIENCE_S):
            head = await self.reader.readexactly(7)
            transaction, protocol, length, unit = struct.unpack(">HHHB", head)
            assert protocol == 0
            return transaction, unit, await self.reader.readexactly(length - 1)

    async def ask(self, pdu: bytes, unit: int = 1) -> bytes:
        await self.send(packet(pdu, unit=unit))
        return (await self.answer())[2]

    async def is_closed(self) -> bool:
        async with asyncio.timeout(PATIENCE_S):
            try:
                return await self.reader.read(1) == b""
            except ConnectionError:
                return True

    async def hears_nothing(self) -> bool:
        try:
            async with asyncio.timeout(NOTHING_S):
                return await self.reader.read(1) is None
        except TimeoutError:
            return True


@dataclass
class Door:
    bridge: ModbusBridge
    desk: Any
    clients: list[RawClient] = field(default_factory=list)

    async def client(self) -> RawClient:
        host, _, number = self.bridge.status()["listen"][0].rpartition(":")
        self.clients.append(RawClient(*await asyncio.open_connection(host, int(number))))
        return self.clients[-1]


@asynccontextmanager
async def open_door(at: Any = None, **options: Any) -> AsyncIterator[Door]:
    of = at or desk()
    bridge = ModbusBridge(Options(listen="127.0.0.1:0", **options), of)
    await bridge.open()
    door = Door(bridge, of)
    try:
        yield door
    finally:
        for client in door.clients:
            client.writer.transport.abort()
        await asyncio.sleep(0)
        await bridge.close()


def with_door(use: Callable[[Door], Awaitable[None]], at: Any = None, **options: Any) -> None:
    async def main() -> None:
        async with open_door(at, **options) as door:
            await use(door)

    asyncio.run(main())
