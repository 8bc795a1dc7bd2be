"""slcan adapters at a bench's CAN bus, on the virtual clock."""

import random

import pytest
from can_bench import TAP, config

from bridges.can.bus.bus_events import NodeState
from bridges.can.cards.can_tap import CLOSED_ROOM, LINE_MAX, STUCK_NS
from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.frame_length import frame_bits
from hil.testing import Bench

BIT_NS = 2000
FRAMES = (b"t", b"T", b"r", b"R")


@pytest.fixture
def bench():
    with Bench(config({}, taps="ab")) as bench:
        bench.run(ms=1)
        yield bench


def opened(bench: Bench, name: str = TAP, how: bytes = b"S6\rO\r"):
    tap = bench.tap(name)
    tap.write(how)
    assert tap.read() == b"\r" * how.count(b"\r")
    bench.run(ms=1)
    return tap


def test_a_frame_goes_from_one_client_to_the_other_in_the_time_of_its_bits(bench: Bench) -> None:
    a, b = opened(bench), opened(bench, "can0.b")
    began_ns = bench.now_ns
    a.write(b"t1232BEEF\rT1ABCDEF00\r")
    assert a.read() == b"z\rZ\r", "at once"
    bench.run(ms=1)
    heard = b.read_timed()
    assert bytes(byte for _, byte in heard) == b"t1232BEEF\rT1ABCDEF00\r"
    first_ns = began_ns + frame_bits(CanFrame(0x123, b"\xbe\xef")) * BIT_NS
    assert {at_ns for at_ns, byte in heard[:10]} == {first_ns}
    second_ns = first_ns + (3 + frame_bits(CanFrame(0x1ABCDEF0, is_extended=True))) * BIT_NS
    assert {at_ns for at_ns, byte in heard[10:]} == {second_ns}
    assert a.read() == b"", "an adapter does not hear itself"


def test_a_closed_adapter_is_no_part_of_the_bus(bench: Bench) -> None:
    a = opened(bench)
    a.write(b"t1230\r")
    bench.run(ms=50)
    bus = bench.canbus("can0").bus
    assert bus.counters(1)["errors"]["acknowledgement"] > 1
    assert bus.state("can0.a") is NodeState.PASSIVE
    assert bus.state("can0.b") is NodeState.OFF


def test_flags_tell_of_errors_and_are_cleared_by_reading() -> None:
    with Bench(config({}, taps="ab")) as bench:
        a = opened(bench)
        a.write(b"t1230\r")
        bench.run(ms=50)
        a.write(b"F\r")
        assert a.read() == b"z\rFA4\r", "bus error, passive, warning"
        b = opened(bench, "can0.b")
        bench.run(ms=50)
        a.write(b"F\r")
        assert a.read() == b"F84\r", "with one error less it is active again"
        bench.run(ms=1)
        a.write(b"F\r")
        assert a.read() == b"F04\r"
        assert b.read() == b"t1230\r"


def test_listening_only_it_neither_acknowledges_nor_sends(bench: Bench) -> None:
    a, b = opened(bench), opened(bench, "can0.b", b"S6\rL\r")
    b.write(b"t1230\r")
    assert b.read() == b"\a"
    a.write(b"t1230\r")
    bench.run(ms=1)
    assert b.read() == b"", "it hears no whole frame: nobody acknowledges"
    c = bench.canbus()
    bench.run(ms=5)
    assert b.read() == b"t1230\r"
    assert [str(each.frame) for each in c.read()] == ["123#"]


def test_another_rate_than_the_bus_has_destroys_frames(bench: Bench) -> None:
    a = opened(bench)
    canbus = bench.canbus()
    bench.tap("can0.b").write(b"S5\rO\r")
    bench.run(ms=1)
    a.write(b"t12380123456789ABCDEF\r")
    bench.run(ms=2)
    assert canbus.read() == []
    notes = bench._runtime.taps["can0.b"].notes
    assert notes == {0: "its client has opened it with 250000 bit/s on a bus of 500000"}
    bench.tap("can0.b").write(b"C\r")
    assert canbus.expect(0x123).frame.data == bytes.fromhex("0123456789ABCDEF")
    assert notes == {}


def test_what_was_not_sent_is_lost_when_the_client_closes(bench: Bench) -> None:
    a = opened(bench)
    a.write(b"t1230\rt1240\rC\r")
    canbus = bench.canbus()
    bench.run(ms=10)
    assert canbus.read() == []
    a.write(b"O\rt1250\r")
    assert canbus.expect(0x125)


def test_a_client_is_held_up_while_frames_go_and_told_when_they_do_not(bench: Bench) -> None:
    tap = bench._runtime.taps[TAP]
    assert tap.room(bench.now_ns) == CLOSED_ROOM
    a = opened(bench)
    room = tap.room(bench.now_ns)
    a.write(b"t1230\r" * (room // 6))
    assert a.read() == b"z\r" * 64, "room is for frames that have mailboxes"
    assert tap.room(bench.now_ns) == 0
    told = []
    tap.listeners.append(lambda: told.append(bench.now_ns))
    bench.run(ms=990)
    assert (tap.room(bench.now_ns), tap.room_ns) == (0, 1_000_000 * 2 + STUCK_NS), "nobody acknowledges"
    bench.run(ms=20)
    assert tap.room(bench.now_ns) == LINE_MAX
    a.write(b"t1230\r")
    assert a.read() == b"\a"
    tap.room(bench.now_ns)
    bench.canbus()
    assert tap._is_short
    bench.run(ms=2)
    assert told
    assert tap.room(bench.now_ns) > 0


def test_frames_of_a_client_go_in_its_order_whatever_their_urgency(bench: Bench) -> None:
    a, canbus = opened(bench), bench.canbus()
    bench.run(ms=1)
    a.write(b"t3000\rt2000\rt0800\r")
    bench.run(ms=2)
    assert [each.frame.id for each in canbus.read()] == [0x300, 0x200, 0x080]


def test_a_tap_that_babbles_still_sends_what_its_client_has(bench: Bench) -> None:
    a, canbus = opened(bench), bench.canbus()
    bench.run(ms=1)
    with bench.fault("node_babble", TAP, every_ms=0.1):
        a.write(b"t3000\r" * 3)
        bench.run(ms=20)
    assert canbus.expect(0x300, within_ms=50)
    bench.run(ms=50)
    assert sum(each.frame.id == 0x300 for each in canbus.heard) == 3


def test_bursts_are_sent_at_their_times(bench: Bench) -> None:
    from hil.sim.inputs import Play

    opened(bench)
    canbus = bench.canbus()
    bench.run(ms=1)
    runtime, began_ns = bench._runtime, bench.now_ns
    runtime.apply_to(runtime.taps[TAP], Play(((0, b"t1230\r".hex()), (5_000_000, b"t1240\r".hex()))))
    bench.run(ms=10)
    bits = frame_bits(CanFrame(0x124))
    assert canbus.read()[1].at_ns == began_ns + 5_000_000 + bits * BIT_NS


def garbage(chance: random.Random, size: int) -> bytes:
    """Bytes of which many are nearly commands."""
    out = bytearray()
    while len(out) < size:
        kind = chance.randrange(4)
        if kind == 0:
            out += chance.randbytes(chance.randrange(40))
        elif kind == 1:
            out += bytes(chance.choices(b"tTrRSsOLCFVNZMm0123456789abcdefABCDEF\r\n", k=chance.randrange(30)))
        else:
            line = bytearray(chance.choice((b"t1232BEEF", b"T1ABCDEF3001122", b"S6", b"O", b"F", b"C")))
            line[chance.randrange(len(line))] = chance.randrange(256)
            out += (line if kind == 2 else chance.choice((b"S6\rO", b"t1000"))) + b"\r"
    return bytes(out[:size])


def test_a_hundred_thousand_bytes_of_garbage_do_no_harm() -> None:
    """Each line gets one answer, and the adapter is whole afterwards."""
    chance = random.Random(1)
    with Bench(config(taps="ab")) as bench:
        canbus = bench.canbus()
        a = bench.tap(TAP)
        data = garbage(chance, 100_000)
        at = 0
        while at < len(data):
            piece = data[at : at + chance.randrange(1, 200)]
            at += len(piece)
            a.write(piece)
            bench.run(ms=0.5)
        said = a.read()
        of_lines = [each for each in said.replace(b"\a", b"").split(b"\r")[:-1] if each[:1] not in FRAMES]
        assert said.count(b"\a") + len(of_lines) == data.count(b"\r")
        assert bench.device("m1").failed is None
        a.write(b"\rC\r")
        bench.run(ms=10)
        a.read()
        canbus.read()
        opened(bench)
        a.write(b"t1232BEEF\r")
        assert canbus.expect(0x123, b"\xbe\xef", within_ms=50)
