"""Whatever a client sends: an exception, or silence, or a closed connection, and nobody else notices."""

import asyncio
import gc
import struct
from collections.abc import Awaitable, Callable

import pytest
from served_door import READ, WAVE, Door, R, RawClient, open_door, packet, with_door

from hil.vocab.desk_protocol import Source
from hil.vocab.verbs import CODES, Role, VerbRefused

GOOD = bytes((4, 4)) + struct.pack(">f", R)
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3


@pytest.mark.parametrize(
    ("pdu", "code"),
    [
        *(
            pytest.param(bytes([function]), ILLEGAL_FUNCTION, id=f"function {function}, not there")
            for function in (0, 7, 8, 9, 11, 12, 17, 20, 24, 65, 100, 127)
        ),
        *(
            pytest.param(bytes([function, 0, 0, 0, 1]), ILLEGAL_FUNCTION, id=f"reserved function {function}")
            for function in (9, 10, 13, 14, 18, 19, 41, 42, 90, 91, 125, 126, 127)
        ),
        pytest.param("04", ILLEGAL_VALUE, id="short: a function alone"),
        pytest.param("04 03e8", ILLEGAL_VALUE, id="short: without a count"),
        pytest.param("10 000b 0002 04 0001", ILLEGAL_VALUE, id="short: a register is missing"),
        pytest.param("04 03e8 0002 00", ILLEGAL_VALUE, id="long by a byte"),
        pytest.param("10 000b 0001 02 0001 0002", ILLEGAL_VALUE, id="long by a register"),
        pytest.param("03 0000 0001" + " 00" * 248, ILLEGAL_VALUE, id="long: the largest PDU"),
        pytest.param("04 03e8 0000", ILLEGAL_VALUE, id="count 0 of registers"),
        pytest.param("01 0000 0000", ILLEGAL_VALUE, id="count 0 of coils"),
        pytest.param("10 000b 0000 00", ILLEGAL_VALUE, id="count 0 of registers to write"),
        pytest.param("04 03e8 007e", ILLEGAL_VALUE, id="oversize count of registers"),
        pytest.param("01 0000 07d1", ILLEGAL_VALUE, id="oversize count of coils"),
        pytest.param("02 0000 ffff", ILLEGAL_VALUE, id="oversize count of discrete inputs"),
        pytest.param("10 000b 007c f8" + " 0000" * 123, ILLEGAL_VALUE, id="oversize count to write"),
        ("04 ffff 0002", ILLEGAL_ADDRESS),
        ("04 03ea 0001", ILLEGAL_ADDRESS),
        ("03 03e8 0002", ILLEGAL_ADDRESS),  # r is not settable
        ("05 0000 1234", ILLEGAL_VALUE),
        ("05 0000 00", ILLEGAL_VALUE),
        ("05 0001 ff00", ILLEGAL_ADDRESS),
        ("06 0001 0000", ILLEGAL_ADDRESS),
        ("06 000b 0063", ILLEGAL_VALUE),
        ("0f 0000 0000 00", ILLEGAL_VALUE),
        ("0f 0000 0001 02 0100", ILLEGAL_VALUE),
        ("0f 0000 0002 01 01", ILLEGAL_ADDRESS),
        ("10 000b 0002 02 0001", ILLEGAL_VALUE),
        ("10 000b 0002 03 000100", ILLEGAL_VALUE),
        pytest.param("10 000c 0002 04 00010001", ILLEGAL_VALUE, id="half: arguments without a command"),
        pytest.param("06 000c 0001", ILLEGAL_VALUE, id="half: one argument"),
        pytest.param("10 000b 0002 04 0001 0001", ILLEGAL_VALUE, id="half: a command with an odd argument"),
        ("16 0001 0000 0000", ILLEGAL_ADDRESS),
        ("16 0000 0000", ILLEGAL_VALUE),
        ("17 000b 0001 000b 0001 04 0001", ILLEGAL_VALUE),
        ("17 0063 0001 000b 0001 02 0001", ILLEGAL_ADDRESS),  # it is not written, either
        pytest.param("2b 0d 00", ILLEGAL_FUNCTION, id="unknown MEI type"),
        pytest.param("08 0063 0000", ILLEGAL_FUNCTION, id="unknown sub-function of what lines have"),
        ("2b 0e 05 00", ILLEGAL_VALUE),
        ("2b 0e 04 63", ILLEGAL_ADDRESS),
    ],
)
def test_requests_that_are_refused(pdu: str | bytes, code: int) -> None:
    data = bytes.fromhex(pdu) if isinstance(pdu, str) else pdu

    async def use(door: Door) -> None:
        client = await door.client()
        assert await client.ask(data) == bytes((data[0] | 0x80, code))
        assert door.desk.done == []
        assert await client.ask(READ) == GOOD
        assert door.bridge.status()["exceptions"] == {f"{code:02}": 1}

    with_door(use)


@pytest.mark.parametrize("unit", [0, 3, 200, 247, 248, 255])
def test_a_wrong_unit(unit: int) -> None:
    async def use(door: Door) -> None:
        assert await (await door.client()).ask(READ, unit) == b"\x84\x0a"

    with_door(use)


def test_the_only_unit_is_meant_by_0_and_255() -> None:
    async def use(door: Door) -> None:
        client = await door.client()
        for unit in (0, 9, 255):
            assert await client.ask(READ, unit) == GOOD
        assert await client.ask(READ, 1) == b"\x84\x0a"

    with_door(use, units={"m1": 9})


def test_a_unit_whose_axis_has_gone() -> None:
    async def use(door: Door) -> None:
        client, gone = await door.client(), door.desk.devices.pop("m1")
        await door.bridge.devices_changed(["m1"])
        assert await client.ask(READ, 9) == b"\x84\x0b"
        door.desk.devices["m1"] = gone
        await door.bridge.devices_changed(["m1"])
        assert await client.ask(READ, 9) == GOOD

    with_door(use, units={"m1": 9, "m2": 10})


@pytest.mark.parametrize(
    "head",
    [
        pytest.param("0001 0001 0006 01", id="protocol 1"),
        pytest.param("0001 ffff 0006 01", id="protocol 65535"),
        pytest.param("0001 0000 0000 01", id="length field 0"),
        pytest.param("0001 0000 0001 01", id="length field 1"),
        pytest.param("0001 0000 00ff 01", id="length field 255"),
        pytest.param("0001 0000 ffff 01", id="length field 65535"),
    ],
)
def test_lost_framing_closes_that_connection(head: str) -> None:
    async def use(door: Door) -> None:
        client, other = await door.client(), await door.client()
        await client.send(packet(READ, 7) + bytes.fromhex(head) + WAVE)
        assert await client.answer() == (7, 1, GOOD)
        assert await client.is_closed()
        assert await other.ask(READ) == GOOD
        assert door.desk.done == []
        assert door.bridge.status()["closed"] == {"framing": 1}

    with_door(use)


def test_pipelined_requests_are_answered_in_their_order() -> None:
    pdus = [READ, b"\x63", WAVE, bytes.fromhex("01 0000 0001"), bytes.fromhex("04 ffff 0001")] * 40

    async def use(door: Door) -> None:
        client = await door.client()
        await client.send(b"".join(packet(pdu, at) for at, pdu in enumerate(pdus)))
        answers = [await client.answer() for _ in pdus]
        assert [transaction for transaction, _, _ in answers] == list(range(len(pdus)))
        assert [pdu[0] & 0x7F for _, _, pdu in answers] == [pdu[0] for pdu in pdus]

    with_door(use)


@pytest.mark.parametrize("size", [1, 2, 3, 7, 13])
def test_fragmented_requests(size: int) -> None:
    stream = b"".join(packet(READ, at) for at in range(20))

    async def use(door: Door) -> None:
        client = await door.client()
        for at in range(0, len(stream), size):
            await client.send(stream[at : at + size])
            await asyncio.sleep(0)
        assert [await client.answer() for _ in range(20)] == [(at, 1, GOOD) for at in range(20)]

    with_door(use)


@pytest.mark.parametrize(
    ("length", "answer"),
    [
        pytest.param(5, bytes((0x84, 3)), id="too small: the last byte is left over"),
        pytest.param(7, bytes((0x84, 3)), id="too large: a byte of the next one is taken"),
    ],
)
def test_a_wrong_length_field_that_can_be(length: int, answer: bytes) -> None:
    """The next header is out of step, and closes the connection."""

    async def use(door: Door) -> None:
        client, other = await door.client(), await door.client()
        await client.send(struct.pack(">HHHB", 1, 0, length, 1) + READ + packet(WAVE, 2) * 2)
        assert (await client.answer())[2] == answer
        assert await client.is_closed()
        assert await other.ask(READ) == GOOD
        assert door.desk.done == []

    with_door(use)


def test_half_a_request_and_silence_disturb_nobody() -> None:
    async def use(door: Door) -> None:
        silent, other = await door.client(), await door.client()
        await silent.send(packet(WAVE)[:9])
        for _ in range(50):
            assert await other.ask(READ) == GOOD
        assert await silent.hears_nothing()
        assert door.desk.done == []
        await silent.send(packet(WAVE)[9:])
        assert (await silent.answer())[2] == WAVE

    with_door(use)


async def _abandon(client: RawClient) -> None:
    client.writer.transport.abort()


async def _floods(client: RawClient) -> None:
    """Ask for much, and read nothing."""
    client.writer.write(packet(READ) * 20_000)


@pytest.mark.parametrize("does", [_abandon, _floods])
def test_others_go_on(does: Callable[[RawClient], Awaitable[None]]) -> None:
    async def use(door: Door) -> None:
        other = await door.client()
        for _ in range(10):
            await does(await door.client())
            assert await other.ask(READ) == GOOD

    with_door(use)


def test_a_thousand_connections() -> None:
    async def use(door: Door) -> None:
        asking = await door.client()
        assert await asking.ask(READ) == GOOD
        for _ in range(1000):
            await door.client()
        assert door.bridge.status()["links"] <= 64
        assert await asking.ask(READ) == GOOD  # who has asked stays, while silent ones give way
        assert await (await door.client()).ask(READ) == GOOD

    with_door(use)


@pytest.mark.parametrize("code", CODES)
def test_every_refusal_is_an_exception(code: str) -> None:
    async def use(door: Door) -> None:
        client = await door.client()
        door.desk.refusal = VerbRefused(code, "why not")
        answer = await client.ask(WAVE)
        assert answer[0] == 0x85
        assert answer[1] in (1, 2, 3, 4, 6, 10, 11)
        assert await client.ask(bytes.fromhex("02 012c 0001")) == bytes.fromhex("02 01 01")  # refused
        door.desk.refusal = None
        assert await client.ask(WAVE) == WAVE
        assert await client.ask(bytes.fromhex("02 0000 0001")) == bytes.fromhex("02 01 01")  # done
        assert door.desk.done == [("m1", "wave")]

    with_door(use)


def test_a_client_is_an_operator() -> None:
    async def use(door: Door) -> None:
        await (await door.client()).ask(WAVE)
        assert {source for source, _, _ in door.desk.asked} == {
            Source("modbus client", Role.OPERATOR, door="modbus")
        }

    with_door(use)


@pytest.mark.parametrize("leaves", [False, True])
def test_a_door_that_closes_at_any_moment_leaves_nothing_behind(leaves: bool) -> None:
    """A request that was begun and never awaited, or a socket, would be a warning, which fails tests."""

    async def main(turns: int) -> None:
        async with open_door() as door:
            client = await door.client()
            client.writer.write(packet(WAVE) * 3)
            for _ in range(turns):
                await asyncio.sleep(0)
            if leaves:
                client.writer.transport.abort()

    for turns in range(16):
        asyncio.run(main(turns))
    gc.collect()
