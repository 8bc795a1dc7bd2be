"""Units on a serial line, at a port in memory: silence, addresses, broadcasts, diagnosis."""

import asyncio
import struct
from collections.abc import Awaitable, Callable

import pytest
from served_door import LOOK, READ, WAVE, R

from bridges.modbus.bridge import ModbusBridge, Options
from hil.testing import RecordingDesk
from hil.vocab.ports import PortError, PortHost, PortStats
from hil.wire.modbus_rtu.frame import encode

GOOD = encode(1, 4, b"\4" + struct.pack(">f", R))
PATIENCE_S = 10.0


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


def on_line(use: Callable[[Line], Awaitable[None]], **options: object) -> None:
    async def main() -> None:
        desk, port = RecordingDesk({"look": LOOK}), MemoryPort()
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

    asyncio.run(main())


def test_a_request_and_its_answer() -> None:
    async def use(line: Line) -> None:
        assert await line.ask(good(READ)) == GOOD
        assert await line.ask(good(WAVE)) == good(WAVE)
        assert line.desk.done == [("m1", "wave")]
        assert await line.ask(good(bytes.fromhex("04 ffff 0001"))) == encode(1, 0x84, b"\2")

    on_line(use)


@pytest.mark.parametrize(
    "frame",
    [
        good(WAVE)[:-1] + b"\0",
        good(WAVE)[:5],
        good(WAVE) + b"\1",
        good(WAVE, 3),
        good(WAVE, 255),
        good(READ, 0),
        b"\1\5\0",
        b"a" * 300,
    ],
)
def test_silence_is_the_answer(frame: bytes) -> None:
    async def use(line: Line) -> None:
        assert await line.is_silent_after(frame)
        assert line.desk.done == []

    on_line(use)


def test_a_frame_in_pieces() -> None:
    async def use(line: Line) -> None:
        frame = good(READ)
        for at in range(len(frame) - 1):
            line.port.host.received(frame[at : at + 1])
        assert await line.ask(frame[-1:]) == GOOD

    on_line(use)


def test_a_broadcast_reaches_all_and_nobody_answers() -> None:
    async def use(line: Line) -> None:
        assert await line.is_silent_after(good(WAVE, 0))
        assert line.desk.done == [("m1", "wave"), ("m2", "wave")]

    on_line(use)


def test_a_line_with_units_of_its_own() -> None:
    async def use(line: Line) -> None:
        assert (await line.ask(good(WAVE, 17)))[:2] == b"\x11\5"
        assert await line.ask(good(READ, 9)) == encode(9, 4, GOOD[2:-2])
        assert line.desk.done == [("m2", "wave")]

    on_line(use, units={"m1": 9, "m2": 17})


def test_diagnosis() -> None:
    async def use(line: Line) -> None:
        def asks(sub: int, data: int = 0) -> bytes:
            return good(struct.pack(">BHH", 8, sub, data))

        async def count(sub: int) -> int:
            return int.from_bytes((await line.ask(asks(sub)))[4:6], "big")

        assert await line.ask(asks(0, 0xA537)) == asks(0, 0xA537)
        assert await line.ask(asks(10)) == asks(10)
        line.port.host.received(b"nonsense")
        await asyncio.sleep(0.05)
        await line.ask(good(bytes.fromhex("04 ffff 0001")))
        assert await count(12) == 1  # errors of the line
        assert await count(13) == 1  # exceptions
        assert await count(11) == 4  # frames since they were cleared, this one too
        assert await line.ask(good(b"\x11")) == encode(1, 17, b"\x09specimen\xff")
        line.port.host.received(asks(4))  # listens only from now on
        line.port.host.received(b"")
        await asyncio.sleep(0.05)
        line.port.host.received(good(READ))
        await asyncio.sleep(0.05)
        assert line.port.sent.empty()
        line.port.host.received(asks(1))
        await asyncio.sleep(0.05)
        assert await line.ask(good(READ)) == GOOD

    on_line(use)


def test_a_port_that_cannot_be_opened() -> None:
    class Taken(MemoryPort):
        async def open(self, host: PortHost) -> None:
            raise PortError("pty port of modbus0: taken; choose another path")

    async def main() -> None:
        options = Options.model_validate({"listen": "127.0.0.1:0", "rtu": [{"path": "plc"}]})
        bridge = ModbusBridge(options, RecordingDesk())
        bridge.take_ports([Taken()])
        with pytest.raises(Exception, match="rtu: pty port of modbus0: taken"):
            await bridge.open()

    asyncio.run(main())
