"""A wire whose packets are told apart by silence, with another framing than the rest of the tests have."""

from wire_rig import Wire, characters_ns

from bridges.modbus.protocol.frame import encode
from bridges.modbus.protocol.rtu_framing import MODBUS_RTU
from hil.wire.serial_line import silence_ns

BAUD = 38400
SILENCE_NS = silence_ns(BAUD)
ASK, ANSWER = encode(17, 3, b"\0\x6b\0\3"), encode(17, 3, b"\6\2\x2b\0\0\0\x64")


def line(*names: str) -> Wire:
    return Wire(*names, framing=MODBUS_RTU)


def test_only_those_hear_a_frame_that_it_concerns() -> None:
    wire = line("master", "n17", "n18")
    wire.set_address("n17", 17)
    wire.set_address("n18", 18)
    wire.send("master", 0, ASK)
    wire.send("n17", 10**8, ANSWER)
    wire.send("master", 2 * 10**8, encode(0, 6, b"\0\1\0\3"))
    heard = wire.heard()
    assert heard["n18"] == encode(0, 6, b"\0\1\0\3"), "what is for everybody alone"
    assert heard["n17"] == ASK + encode(0, 6, b"\0\1\0\3")
    assert heard["master"] == ANSWER


def test_a_frame_counts_when_the_silence_behind_it_is_over() -> None:
    wire = line("a", "b")
    wire.send("a", 0, ASK)
    end_ns = characters_ns(len(ASK))
    wire.clock.run(end_ns + SILENCE_NS - 1)
    assert wire.stats.packets == 0
    wire.clock.run(end_ns + SILENCE_NS)
    assert wire.stats.packets == 1


def test_a_frame_in_two_bursts_is_one_and_two_too_close_are_none() -> None:
    wire = line("a", "b", "c")
    wire.set_address("c", 99)
    wire.send("a", 0, ASK[:5])
    wire.send("a", characters_ns(5), ASK[5:])
    wire.send("a", 10**8, ASK)
    wire.send("a", 10**8 + characters_ns(len(ASK)) + SILENCE_NS - 1, ASK)
    assert wire.heard() == {"a": b"", "b": ASK * 3, "c": b""}
    assert (wire.stats.packets, wire.stats.errors) == (1, {"gap": 1})


def test_after_a_collision_the_next_frame_is_one() -> None:
    wire = line("a", "b", "c")
    wire.send("a", 0, ASK)
    wire.send("b", 1000, ANSWER)
    wire.send("a", 10**8, ASK)
    heard = wire.heard()
    assert wire.stats.collisions == 1
    assert heard["c"].endswith(ASK)
    assert (wire.stats.packets, wire.stats.errors) == (2, {"CRC": 1}), (
        "what the collision left, and the frame"
    )


def test_a_collision_takes_back_that_a_frame_had_begun() -> None:
    wire = line("a", "b", "c")
    wire.send("a", 0, ASK)
    wire.send("b", characters_ns(2), b"\xff\xff")
    wire.heard()
    assert (wire.stats.packets, wire.stats.errors) == (1, {"CRC": 1}), "it is counted once"
