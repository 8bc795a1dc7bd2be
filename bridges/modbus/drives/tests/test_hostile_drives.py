"""Real drives that answer late, wrongly, or not at all: they are not believed, and hold nothing up."""

import asyncio
import os
import struct
from collections.abc import Awaitable, Callable

import pytest
from drive_world import in_drive_world
from foreign_drives import Answering, ForeignDrives, HostileDrive, Registers, framed
from modbus_world import ModbusWorld

from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_MS
from hil.vocab.verbs import VerbRefused

pytestmark = pytest.mark.long

WRITES = (5, 6, 15, 16)
LONG = (PathPiece(20_000 * NS_PER_MS, 0.0, 10.0), PathPiece(0, 200.0))


def with_hostile(
    answer: Answering, doing: Callable[[ModbusWorld, HostileDrive, str], Awaitable[None]]
) -> None:
    """Run with a hostile drive beside a good one, which may not notice."""

    async def run(world: ModbusWorld) -> None:
        hostile, good = HostileDrive(answer), ForeignDrives(1)
        port = await hostile.listen()
        beside = await world.there(
            world.add("good", f"modbus+tcp://127.0.0.1:{await good.listen()}?unit=1", timeout_s=2.0)
        )
        try:
            await doing(world, hostile, f"modbus+tcp://127.0.0.1:{port}?unit=1")
            counters = beside.drive.link.counters
            await world.until(lambda: counters.polls > 20, "polls of the good one")
            assert beside.drive.link.is_there
            assert (counters.time_outs, counters.garbled, counters.exceptions) == (0, 0, 0)
        finally:
            await world.close()
            await hostile.close()
            await good.close()

    in_drive_world(ModbusWorld, run)


async def nothing(request: bytes, writer: asyncio.StreamWriter) -> None:
    """Answer nothing, as behind a half-open connection."""


async def late(request: bytes, writer: asyncio.StreamWriter) -> None:
    await asyncio.sleep(0.3)
    writer.write(framed(request, Registers().pdu(request)))


async def garbage(request: bytes, writer: asyncio.StreamWriter) -> None:
    writer.write(os.urandom(40))


async def flood(request: bytes, writer: asyncio.StreamWriter) -> None:
    for _ in range(50):
        writer.write(os.urandom(20_000))
        await writer.drain()


async def other_transaction(request: bytes, writer: asyncio.StreamWriter) -> None:
    writer.write(framed(request, Registers().pdu(request), transaction=40_000))


async def other_unit(request: bytes, writer: asyncio.StreamWriter) -> None:
    writer.write(framed(request, Registers().pdu(request), unit=2))


async def other_protocol(request: bytes, writer: asyncio.StreamWriter) -> None:
    answer = bytearray(framed(request, Registers().pdu(request)))
    answer[2:4] = b"\x12\x34"
    writer.write(bytes(answer))


async def other_function(request: bytes, writer: asyncio.StreamWriter) -> None:
    writer.write(framed(request, b"\x01\x01\x00"))


async def no_function(request: bytes, writer: asyncio.StreamWriter) -> None:
    writer.write(framed(request, b"\x6e\x01\x00"))


async def too_few(request: bytes, writer: asyncio.StreamWriter) -> None:
    writer.write(framed(request, bytes((request[7], 2, 0, 0))))


async def cut_off(request: bytes, writer: asyncio.StreamWriter) -> None:
    writer.write(framed(request, bytes((request[7], 12, 0, 0))))


async def half_an_answer(request: bytes, writer: asyncio.StreamWriter) -> None:
    writer.write(framed(request, Registers().pdu(request))[:-1])


async def no_position(request: bytes, writer: asyncio.StreamWriter) -> None:
    writer.transport.abort()


HOSTILE = (nothing, late, garbage, flood, other_transaction, other_unit, other_protocol)
HOSTILE += (other_function, no_function, too_few, cut_off, half_an_answer, no_position)


@pytest.mark.thorough
@pytest.mark.parametrize("answer", HOSTILE, ids=lambda answer: answer.__name__)
def test_what_is_no_answer_is_not_believed_and_holds_nothing_up(answer: Answering) -> None:
    async def doing(world: ModbusWorld, hostile: HostileDrive, at: str) -> None:
        bad = world.add("bad", at, timeout_s=0.1)
        await asyncio.sleep(1.5)
        assert not bad.drive.link.is_there
        assert bad.drive.reading is None
        assert bad.drive.link.why
        # Waits grow: it is asked a few times, and not all the time.
        assert 2 <= len(hostile.heard) <= 15
        assert hostile.connects <= 6
        with pytest.raises(VerbRefused, match="bad is not there"):
            await bad.do("enable", {})
        assert "it is a real drive, and not there" in str(bad.axis.now().why_not)

    with_hostile(answer, doing)


def test_a_listener_that_is_not_there_is_tried_again() -> None:
    async def doing(world: ModbusWorld, hostile: HostileDrive, at: str) -> None:
        port = await hostile_port(hostile)
        await hostile.close()
        bad = world.add("bad", at)
        await world.until(lambda: "Connection refused" in bad.drive.link.why, "the reason")
        assert bad.drive.link.state == "away"
        await hostile.listen(port)
        await world.there(bad)

    registers = Registers()

    async def well(request: bytes, writer: asyncio.StreamWriter) -> None:
        writer.write(framed(request, registers.pdu(request)))

    with_hostile(well, doing)


async def hostile_port(hostile: HostileDrive) -> int:
    assert hostile._server
    return int(hostile._server.sockets[0].getsockname()[1])


@pytest.mark.thorough
@pytest.mark.parametrize("code", [1, 2, 3, 4, 5, 6, 11, 99])
def test_a_drive_that_refuses_to_be_read_says_why(code: int) -> None:
    async def refuse(request: bytes, writer: asyncio.StreamWriter) -> None:
        writer.write(framed(request, bytes((request[7] | 0x80, code))))

    async def doing(world: ModbusWorld, hostile: HostileDrive, at: str) -> None:
        bad = world.add("bad", at)
        await world.until(lambda: f"exception {code:02}" in bad.drive.link.why, "the reason")
        assert not bad.drive.link.is_there
        assert bad.drive.link.counters.time_outs == 0

    with_hostile(refuse, doing)


@pytest.mark.parametrize("code", [1, 2, 3, 4, 5, 6])
def test_a_write_that_is_refused_fails_its_verb_and_its_run(code: int) -> None:
    registers = Registers()

    async def refuse(request: bytes, writer: asyncio.StreamWriter) -> None:
        is_write = request[7] in WRITES
        pdu = bytes((request[7] | 0x80, code)) if is_write else registers.pdu(request)
        writer.write(framed(request, pdu))

    async def doing(world: ModbusWorld, hostile: HostileDrive, at: str) -> None:
        bad = await world.there(world.add("bad", at))
        with pytest.raises(VerbRefused, match=f"enable: it answered a write .* with exception 0{code}"):
            await bad.do("enable", {})
        assert bad.drive.link.is_there
        bad.axis.hold()
        bad.axis.follow(LONG, world.now_ns)
        await world.until(lambda: bad.axis.failure, "the failure")
        assert f"exception 0{code}" in str(bad.axis.failure)

    with_hostile(refuse, doing)


def test_registers_in_gaps_and_of_the_control_need_not_be_readable() -> None:
    registers = Registers()

    async def careful(request: bytes, writer: asyncio.StreamWriter) -> None:
        code, address, count = struct.unpack(">BHH", request[7:12])
        known = set(range(6)) if code == 4 else {30, 31}
        is_bad = code in (3, 4) and not set(range(address, address + count)) <= known
        writer.write(framed(request, bytes((code | 0x80, 2)) if is_bad else registers.pdu(request)))

    async def doing(world: ModbusWorld, hostile: HostileDrive, at: str) -> None:
        odd = await world.there(world.add("odd", at))
        assert odd.drive.commanded_deg is None
        await odd.do("enable", {})
        assert registers.words[20] == 1
        await odd.set("pKp", 2.0)
        assert registers.words[30:32] == [0x4000, 0]

    with_hostile(careful, doing)


@pytest.mark.parametrize("is_cut", [True, False])
def test_after_a_lost_connection_nothing_of_a_run_is_sent(is_cut: bool) -> None:
    registers = Registers()
    is_deaf = asyncio.Event()

    async def well(request: bytes, writer: asyncio.StreamWriter) -> None:
        if not is_deaf.is_set():
            writer.write(framed(request, registers.pdu(request)))

    async def doing(world: ModbusWorld, hostile: HostileDrive, at: str) -> None:
        axis = (await world.there(world.add("x", at, timeout_s=0.1))).axis
        axis.hold()
        axis.follow(LONG, world.now_ns)
        await world.until(lambda: sum(each[7] == 16 for each in hostile.heard) > 5, "set-points")
        if is_cut:
            hostile.cut()
        else:
            is_deaf.set()
        await world.until(lambda: axis.failure, "the failure")
        assert "is lost: " in str(axis.failure) or "no answer within 0.1 s" in str(axis.failure)
        await world.until(lambda: not axis.drive.link.is_there or is_cut, "the loss")
        axis.stop("grace", 100.0)
        hostile.heard.clear()
        is_deaf.clear()
        await world.there(world.drives["x"])
        await asyncio.sleep(0.3)
        assert not [each for each in hostile.heard if each[7] in WRITES]
        assert axis.failure is not None  # of this run, for good
        with pytest.raises(VerbRefused):
            axis.follow(LONG, world.now_ns)
        axis.release()
        axis.hold()
        assert axis.failure is None

    with_hostile(well, doing)


def test_a_drive_that_is_lost_keeps_its_last_state_with_its_age() -> None:
    registers, is_deaf = Registers(), asyncio.Event()

    async def well(request: bytes, writer: asyncio.StreamWriter) -> None:
        if not is_deaf.is_set():
            writer.write(framed(request, registers.pdu(request)))

    async def doing(world: ModbusWorld, hostile: HostileDrive, at: str) -> None:
        x = await world.there(world.add("x", at, timeout_s=0.1))
        assert x.drive.values()["age_ms"] < 200
        is_deaf.set()
        await world.until(lambda: not x.drive.link.is_there, "the loss")
        await asyncio.sleep(0.3)
        told = x.drive.values()
        assert (told["connected"], told["position_deg"]) == (0, 0.0)
        assert told["age_ms"] > 300
        assert "no answer within 0.1 s, 3 times in a row" in x.drive.link.why or hostile.connects > 1
        is_deaf.clear()
        await world.there(x)
        assert x.drive.values()["reconnects"] == 1

    with_hostile(well, doing)


def test_a_drive_that_begins_to_refuse_is_not_believed_to_be_there() -> None:
    registers, refuses = Registers(), asyncio.Event()

    async def odd(request: bytes, writer: asyncio.StreamWriter) -> None:
        pdu = bytes((request[7] | 0x80, 4)) if refuses.is_set() else registers.pdu(request)
        writer.write(framed(request, pdu))

    async def doing(world: ModbusWorld, hostile: HostileDrive, at: str) -> None:
        x = await world.there(world.add("x", at))
        refuses.set()
        await world.until(lambda: not x.drive.link.is_there, "the loss")
        assert "exception 04 (device failure)" in x.drive.link.why
        refuses.clear()
        await world.there(x)
        assert x.drive.link.session == 2

    with_hostile(odd, doing)


@pytest.mark.parametrize("refuses_both", [False, True])
def test_a_drive_without_the_function_for_one_register_is_written_by_that_for_several(
    refuses_both: bool,
) -> None:
    registers = Registers()

    async def answer(request: bytes, writer: asyncio.StreamWriter) -> None:
        code = request[7]
        is_refused = code == 6 or (refuses_both and code == 16)
        writer.write(framed(request, bytes((code | 0x80, 1)) if is_refused else registers.pdu(request)))

    async def doing(world: ModbusWorld, hostile: HostileDrive, at: str) -> None:
        control = await world.there(world.add("x", at))
        if refuses_both:
            with pytest.raises(VerbRefused, match=r"exception 01 \(illegal function\)"):
                await control.do("enable", {})
        else:
            await control.do("enable", {})
            await control.do("enable", {})
        written = [request[7] for request in hostile.heard if request[7] in WRITES]
        assert written[0] == 6
        assert written.count(6) == 1, "it is remembered"
        assert 16 in written

    with_hostile(answer, doing)
