"""Units on a serial line, at a port in memory: silence, addresses, broadcasts, diagnosis."""

import asyncio
import struct
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest
from served_door import LOOK, READ, WAVE
from served_line import GOOD, Line, MemoryPort, good, on_line

from bridges.modbus.door.door_options import Options
from bridges.modbus.door.modbus_bridge import ModbusBridge
from bridges.modbus.protocol.frame import encode
from hil.testing import RecordingDesk
from hil.vocab.desk_protocol import Source
from hil.vocab.parameters import Parameter
from hil.vocab.ports import PortError, PortHost
from hil.vocab.verbs import Verb, table_of


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
        pytest.param(good(WAVE)[:-1] + b"\0", id="wrong CRC"),
        pytest.param(good(WAVE)[:-2] + good(WAVE)[:-3:-1], id="wrong CRC: its bytes the other way round"),
        pytest.param(good(WAVE)[:5], id="short: it breaks off"),
        pytest.param(b"\1\5\0", id="short: less than a frame"),
        pytest.param(good(WAVE) + b"\1", id="long by a byte"),
        pytest.param(b"a" * 300, id="long: more than a frame can have"),
        pytest.param(good(WAVE) * 2, id="pipelined: no silence between two"),
        pytest.param(good(WAVE, 3), id="wrong unit"),
        pytest.param(good(WAVE, 248), id="wrong unit: a reserved one"),
        pytest.param(good(WAVE, 255), id="wrong unit: no gateway"),
        pytest.param(good(READ, 0), id="a broadcast that reads"),
    ],
)
def test_silence_is_the_answer(frame: bytes) -> None:
    async def use(line: Line) -> None:
        assert await line.is_silent_after(frame)
        assert line.desk.done == []

    on_line(use)


def test_a_fragmented_frame() -> None:
    async def use(line: Line) -> None:
        frame = good(READ)
        for at in range(len(frame) - 1):
            line.port.host.received(frame[at : at + 1])
        assert await line.ask(frame[-1:]) == GOOD

    on_line(use)


@pytest.mark.parametrize(
    ("pdu", "code"),
    [
        pytest.param(bytes.fromhex("63"), 1, id="reserved function"),
        pytest.param(bytes.fromhex("08 0063 0000"), 1, id="unknown sub-function"),
        pytest.param(bytes.fromhex("08 000a"), 3, id="sub-function without its data"),
        pytest.param(bytes.fromhex("04 0000 0000"), 3, id="count 0"),
        pytest.param(bytes.fromhex("04 0000 007e"), 3, id="oversize count"),
    ],
)
def test_a_good_frame_with_a_bad_request_gets_an_exception(pdu: bytes, code: int) -> None:
    async def use(line: Line) -> None:
        assert await line.ask(good(pdu)) == encode(1, pdu[0] | 0x80, bytes([code]))

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
        assert await line.ask(good(b"\x11")) == encode(1, 17, b"\x0a\1\xffspecimen")
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


TO_DEG = 2000 + 32
HALF = struct.pack(">BHH", 6, TO_DEG, 0x42B4)  # the high register of 90.0
REST = struct.pack(">BHH", 6, TO_DEG + 1, 0)
BOTH = struct.pack(">BHH", 3, TO_DEG, 2)


def registers(value: float) -> bytes:
    return encode(1, 3, b"\4" + struct.pack(">f", value))


class Noting(RecordingDesk):
    """Desk that notes the parameters, too."""

    def ask(self, source: Source, operation: str, target: str, given: Mapping[str, object]) -> Any:
        self.given = given
        return super().ask(source, operation, target, given)


def go() -> Noting:
    desk = Noting({"look": LOOK})
    for name, device in desk.devices.items():
        parameter = Parameter("to_deg", "where to", "deg", -1000, 1000, 7.0)
        verbs = table_of((Verb("wave", "waves"), Verb("go", "goes", (parameter,))))
        desk.devices[name] = replace(device, verbs=verbs)
    return desk


def test_a_half_written_value_is_read_as_it_was_written_and_means_nothing_yet() -> None:
    desk = go()

    async def use(line: Line) -> None:
        assert await line.ask(good(BOTH)) == registers(7.0)
        assert await line.ask(good(HALF)) == good(HALF)
        assert await line.ask(good(BOTH)) == encode(1, 3, b"\4\x42\xb4" + struct.pack(">f", 7.0)[2:])
        await line.ask(good(bytes.fromhex("05 0001 ff00")))
        assert desk.given == {"name": "go", "parameters": {"to_deg": 7.0}}
        assert await line.ask(good(REST)) == good(REST)
        assert await line.ask(good(BOTH)) == registers(90.0)

    on_line(use, desk)


def test_halves_go_with_the_client_that_wrote_them() -> None:
    async def use(line: Line) -> None:
        assert await line.ask(good(HALF)) == good(HALF)
        line.port.host.client_left(None)
        assert await line.ask(good(BOTH)) == registers(7.0)
        assert await line.ask(good(REST)) == good(REST)
        line.port.host.client_left(None)
        assert await line.ask(good(BOTH)) == registers(7.0)

    on_line(use, go())


def test_halves_on_a_line_whose_clients_nobody_sees_are_forgotten() -> None:
    async def use(line: Line) -> None:
        for _ in range(3):  # each write begins the time again
            assert await line.ask(good(HALF)) == good(HALF)
            await asyncio.sleep(6)
        assert (await line.ask(good(BOTH)))[3:5] == b"\x42\xb4"
        await asyncio.sleep(11)
        assert await line.ask(good(REST)) == good(REST)
        assert (await line.ask(good(BOTH)))[3:7] == struct.pack(">f", 7.0)[:2] + b"\0\0"

    on_line(use, go())


def test_a_frame_of_a_client_that_leaves_at_once_is_carried_out_and_nobody_else_gets_its_answer() -> None:
    async def use(line: Line) -> None:
        line.port.host.received(good(WAVE))
        line.port.host.client_left(None)
        assert await line.ask(good(READ)) == GOOD
        assert line.desk.done == [("m1", "wave")]
        line.port.host.received(good(bytes.fromhex("04 0000 0001")))
        line.port.host.client_left(None)
        assert await line.ask(good(READ)) == GOOD
        line.port.host.received(good(WAVE)[:-1])
        line.port.host.client_left(None)
        assert await line.ask(good(READ)) == GOOD
        assert line.errors == 1

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
