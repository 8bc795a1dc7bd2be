"""Mutated requests: each gets an answer of its function, and the units stay in order.

``HIL_FUZZ`` sets how many are tried over TCP (25,000; ``make fuzz``: 10,000,000), with a tenth of it on a
serial line, in simulated time; ``HIL_FUZZ_SEED`` where they start.
"""

import asyncio
import os
import random
import struct
from collections import Counter

import pytest
from served_door import LOOK, Door, RawClient, packet, with_door
from served_line import MemoryPort
from simulated_loop import Simulated

from bridges.modbus.door.request_handler import DoorUnits, RequestHandler
from bridges.modbus.door.rtu_server import RtuServer
from bridges.modbus.protocol.frame import Frame, encode
from bridges.modbus.protocol.identification import Identification
from bridges.modbus.protocol.mbap import MbapSplitter
from hil.testing import RecordingDesk
from hil.vocab.desk_protocol import AxisField
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Verb, table_of

CASES = int(os.environ.get("HIL_FUZZ", "25000"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
AT_ONCE = 64
CODES = {1, 2, 3, 4, 6, 10, 11}
SPREAD = (0, 1, 2, 3, 4, 11, 12, 99, 100, 200, 300, 1000, 1001, 1002, 2000, 2002, 2032, 0xFFFF)
VERBS = (
    Verb("wave", "waves"),
    Verb(
        "go",
        "goes",
        (
            Parameter("to_deg", "where to", "deg", -1000, 1000),
            Parameter("turns", "how often", "", 0, 10, 3, is_whole=True),
            Parameter("way", "which way", choices=("up", "down"), default="up"),
        ),
    ),
)


class Forgetful(RecordingDesk):
    """Desk that need not remember millions of requests."""

    def forget(self) -> None:
        self.asked.clear()
        self.done.clear()


def desk() -> Forgetful:
    made = Forgetful({"look": LOOK, "set": None, "pin": None})
    for name in ("m1", "m2"):
        device = made.devices[name]
        fields = {"r": AxisField("r", "f32", "deg", "set-point", 0, True, True)} if device.fields else {}
        made.devices[name] = type(device)(
            name, "specimen", device.is_real, table_of(VERBS), fields, {"a": "", "b": ""}
        )
    return made


class Mutant:
    """Requests that mean something, some of them spoilt."""

    def __init__(self, chance: random.Random) -> None:
        self._chance = chance

    def pdu(self) -> bytes:
        chance, address = self._chance, self._chance.choice(SPREAD)
        function = chance.choice((1, 2, 3, 4, 5, 6, 8, 15, 16, 17, 22, 23, 43))
        count = chance.choice((1, 2, 3, 4, chance.randrange(130)))
        words = [chance.choice((0, 1, 0x7FC0, 0xFFFF, chance.randrange(1 << 16))) for _ in range(count)]
        body = struct.pack(f">{count}H", *words)
        match function:
            case 1 | 2 | 3 | 4:
                said = struct.pack(">HH", address, count)
            case 5:
                said = struct.pack(">HH", address, chance.choice((0, 0xFF00)))
            case 6:
                said = struct.pack(">HH", address, chance.randrange(1 << 16))
            case 8:
                said = struct.pack(">HH", chance.randrange(23), chance.choice((0, 0, 0xFF00, count)))
            case 17:
                said = b""
            case 15:
                size = -(-count // 8)
                said = struct.pack(">HHB", address, count, size) + chance.randbytes(size)
            case 16:
                said = struct.pack(">HHB", address, count, len(body) & 0xFF) + body
            case 22:
                said = struct.pack(">HHH", address, chance.randrange(1 << 16), chance.randrange(1 << 16))
            case 23:
                said = struct.pack(">HHHHB", address, count, chance.choice(SPREAD), count, len(body) & 0xFF)
                said += body
            case _:
                said = bytes((14, chance.randrange(6), chance.randrange(256)))
        return self._spoilt(bytes([function]) + said)[:253]

    def _spoilt(self, pdu: bytes) -> bytes:
        chance = self._chance
        match chance.randrange(8):
            case 0:
                at = chance.randrange(len(pdu))
                return pdu[:at] + chance.randbytes(1) + pdu[at + 1 :]
            case 1:
                return pdu[: chance.randrange(1, len(pdu) + 1)]
            case 2:
                return pdu + chance.randbytes(chance.randrange(1, 9))
            case 3:
                return chance.randbytes(chance.randrange(1, 60))
        return pdu


async def asked(client: RawClient, pdus: list[bytes], chance: random.Random) -> Counter[str]:
    """Ask for all at once, in pieces; answers how many were refused with which code."""
    units = [chance.choice((1, 1, 1, 2, 3)) for _ in pdus]
    stream = b"".join(packet(pdu, at, unit) for at, (pdu, unit) in enumerate(zip(pdus, units, strict=True)))
    while stream:
        size = chance.randrange(1, 2000)
        await client.send(stream[:size])
        stream = stream[size:]
    seen: Counter[str] = Counter()
    for at, (pdu, unit) in enumerate(zip(pdus, units, strict=True)):
        transaction, answerer, answer = await client.answer()
        assert (transaction, answerer) == (at, unit), pdu.hex()
        if answer[0] & 0x80:
            assert (answer[0], len(answer)) == (pdu[0] | 0x80, 2), (pdu.hex(), answer.hex())
            assert answer[1] in CODES, (pdu.hex(), answer.hex())
            seen[f"{answer[1]:02}"] += 1
        else:
            assert answer[0] == pdu[0], (pdu.hex(), answer.hex())
            seen["answered"] += 1
    return seen


@pytest.mark.long
def test_every_request_has_its_answer() -> None:
    chance = random.Random(SEED)
    mutant = Mutant(chance)

    async def use(door: Door) -> None:
        client, seen = await door.client(), Counter[str]()
        for _ in range(0, CASES, AT_ONCE):
            seen += await asked(client, [mutant.pdu() for _ in range(AT_ONCE)], chance)
            door.desk.forget()
        assert {"answered", "01", "02", "03", "10"} <= seen.keys(), seen
        assert min(seen[kind] for kind in ("answered", "01", "02", "03")) > CASES / 100, seen
        status = door.bridge.status()
        assert status["requests"] == seen.total()
        assert sum(status["exceptions"].values()) == seen.total() - seen["answered"]

    with_door(use, desk())


def test_streams_that_lose_their_framing_end() -> None:
    chance = random.Random(SEED)
    mutant = Mutant(chance)

    async def use(door: Door) -> None:
        other = await door.client()
        for _ in range(CASES // 200):
            stream = bytearray(b"".join(packet(mutant.pdu(), at) for at in range(20)))
            for _ in range(chance.randrange(1, 5)):
                stream[chance.randrange(len(stream))] = chance.randrange(256)
            splitter = MbapSplitter()
            count = len(splitter.feed(bytes(stream)))
            client = await door.client()
            await client.send(bytes(stream))
            for _ in range(count):
                await client.answer()
            if splitter.fault:
                assert await client.is_closed()
            client.writer.transport.abort()
            assert (await other.ask(bytes.fromhex("04 0000 0001")))[:2] == b"\x04\x02"
            door.desk.forget()
        assert door.bridge.status()["closed"]["framing"] > 0
        await asyncio.sleep(0)

    with_door(use, desk())


def fault_of(frame: bytes) -> str:
    return Frame(0, frame).fault


class FuzzedLine:
    """Line whose frames are spoilt. ``quiet``: units that only listen, by what they were told."""

    def __init__(self, port: MemoryPort, chance: random.Random) -> None:
        self._port, self._chance = port, chance
        self._mutant = Mutant(chance)
        self.quiet: set[int] = set()
        self.seen: Counter[str] = Counter()

    async def heard(self, data: bytes) -> bytes | None:
        """Send bytes in pieces, and a silence; answers what came."""
        while data:
            size = self._chance.randrange(1, 300)
            self._port.host.received(data[:size])
            data = data[size:]
        await asyncio.sleep(0.01)
        return None if self._port.sent.empty() else self._port.sent.get_nowait()

    async def try_one(self) -> None:
        chance, pdu = self._chance, self._mutant.pdu()
        address = chance.choice((1, 1, 1, 2, 2, 0, 3, 248))
        frame = self._spoilt(encode(address, pdu[0], pdu[1:253]))
        is_good = 4 <= len(frame) <= 256 and not fault_of(frame)
        address, pdu = frame[0], frame[1:-2]
        was_quiet = address in self.quiet
        if is_good:
            self._follow(address, pdu)
        answer = await self.heard(frame)
        assert self._port.sent.empty(), frame.hex()
        if not is_good or address not in (1, 2) or was_quiet or address in self.quiet:
            assert answer is None, frame.hex()
            self.seen["silence"] += 1
            return
        assert answer is not None, frame.hex()
        assert not fault_of(answer), frame.hex()
        assert len(answer) <= 256, frame.hex()
        assert answer[0] == address, frame.hex()
        assert answer[1] in (pdu[0], pdu[0] | 0x80), (frame.hex(), answer.hex())
        if is_refused := answer[1] & 0x80 != 0:
            assert answer[2] in CODES, frame.hex()
        self.seen["refused" if is_refused else "answered"] += 1

    def _spoilt(self, frame: bytes) -> bytes:
        """A frame, often as it is. Any bytes may have a good CRC, one in 65536."""
        chance = self._chance
        match chance.randrange(16):
            case 0:
                at = chance.randrange(len(frame))
                return frame[:at] + chance.randbytes(1) + frame[at + 1 :]
            case 1:
                return frame[: chance.randrange(1, len(frame))]
            case 2:
                return frame + chance.randbytes(chance.randrange(1, 40))
            case 3:
                return chance.randbytes(chance.randrange(1, 600))
            case _:
                return frame

    def _follow(self, address: int, pdu: bytes) -> None:
        """Note who only listens from now on: 8/4, until 8/1. To all, neither is carried out."""
        to = {address} & {1, 2}
        if pdu == bytes.fromhex("08 0004 0000"):
            self.quiet |= to
        elif pdu[:3] == bytes.fromhex("08 0001") and pdu[3:] in (b"\0\0", b"\xff\0"):
            self.quiet -= to


def test_frames_on_a_line_have_an_answer_or_none() -> None:
    version = bytes.fromhex("0000 0001")

    async def main() -> None:
        port, at = MemoryPort(), desk()
        units = DoorUnits(at, None, is_low_first=False)
        units.open()
        handler = RequestHandler(at, units, lambda unit: Identification("hil", unit.info.name, "1"))
        server, line = RtuServer(port, 115200, handler, units), FuzzedLine(port, random.Random(SEED))
        await server.open()
        try:
            for number in range(CASES // 10):
                await line.try_one()
                if number % 100 == 0:
                    for unit in line.quiet:
                        await line.heard(encode(unit, 8, bytes.fromhex("0001 0000")))
                    line.quiet.clear()
                    at.forget()
                    assert await line.heard(encode(1, 4, version)) == encode(1, 4, b"\2\0\1")
            seen = line.seen
            assert min(seen[kind] for kind in ("silence", "refused", "answered")) > CASES / 200, seen
        finally:
            await server.close()
            await handler.close()

    with asyncio.Runner(loop_factory=Simulated) as runner:
        runner.run(main())
