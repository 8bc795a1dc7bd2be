"""The wire alone: bursts in, what each station's receiver gets out, with times."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from wire_rig import BAUD, Wire, characters_ns

from device_profiles.sac.packet import Malformed, Packet, PacketDecoder, encode
from device_profiles.sac.packet_faults import packet_fault
from hil.vocab.time import FOREVER
from virtual_ports.rs485.waveform import Driving, low_line, read

Y = encode(85, 1, b"y")


def test_a_burst_is_heard_by_all_others_with_the_lines_times():
    wire = Wire("a", "b", "c")
    wire.send("a", 1000, b"hi")
    assert wire.heard() == {"a": b"", "b": b"hi", "c": b"hi"}
    assert [at_ns for at_ns, _ in wire.ears["b"].got] == [1000 + characters_ns(1), 1000 + characters_ns(2)]


def test_only_those_hear_a_packet_that_it_concerns():
    wire = Wire("a", "b", "c", "tap")
    for name, address in (("a", 1), ("b", 85), ("c", 86)):
        wire.set_address(name, address)
    wire.send("a", 0, Y)
    assert wire.heard() == {"a": b"", "b": Y, "c": b"", "tap": Y}
    wire.send("a", 10**9, encode(0, 1, b"y"))
    assert wire.ears["c"].data == encode(0, 1, b"y")
    wire.set_polling("c", False)
    wire.send("a", 2 * 10**9, Y)
    assert wire.ears["c"].data == encode(0, 1, b"y") + Y


def test_a_piece_of_a_packet_is_everybodys():
    wire = Wire("a", "b", "c")
    wire.set_address("c", 86)
    wire.send("a", 0, Y[:3])
    wire.send("a", 10**9, Y[3:])
    assert wire.ears["c"].data == Y


def test_an_echo_is_heard_by_its_sender_alone_if_it_has_one():
    wire = Wire("a", "b")
    wire.stations["a"].has_echo = True
    wire.send("a", 0, b"hi")
    wire.send("b", 10**9, b"ho")
    assert wire.heard() == {"a": b"hiho", "b": b"hi"}


def test_two_that_send_at_once_garble_each_other_for_all():
    wire = Wire("a", "b", "c")
    one, two = encode(0, 85, b"\x11"), encode(0, 86, b"\x11")
    wire.send("a", 0, one)
    wire.send("b", 0, two)
    heard = wire.heard()
    assert heard["a"] == heard["b"] == b""  # their receivers are off
    assert heard["c"] not in (one, two)
    wire.clock.run(10**9)
    assert wire.stats.collisions == 1
    assert [wire.stats.stations[name].collisions for name in "abc"] == [1, 1, 0]


def test_equal_bits_at_equal_times_do_no_harm():
    wire = Wire("a", "b", "c")
    wire.send("a", 0, Y)
    wire.send("b", 0, Y)
    assert wire.heard()["c"] == Y


def test_what_was_complete_before_a_collision_stays():
    wire = Wire("a", "b", "c")
    wire.send("a", 0, b"abcdefgh")
    wire.send("b", characters_ns(4), b"XY")
    wire.heard()
    got = wire.ears["c"].got
    assert bytes(byte for at_ns, byte in got if at_ns <= characters_ns(4)) == b"abcd"
    assert wire.ears["c"].data != b"abcdefgh"
    assert wire.ears["c"].data.endswith(b"gh")


def test_the_line_is_good_again_after_a_collision():
    wire = Wire("a", "b", "c")
    wire.send("a", 0, Y)
    wire.send("b", 100_000, Y)
    wire.heard()
    wire.ears["c"].got.clear()
    wire.send("a", 10**9, Y)
    assert wire.ears["c"].data == Y
    wire.clock.run(2 * 10**9)
    assert (wire.stats.collisions, wire.stats.packets) == (1, 1)


def test_a_driver_that_lets_go_late_spoils_the_answer():
    wire = Wire("a", "b")
    wire.stations["a"].release_ns = characters_ns(4)
    wire.send("a", 0, Y)
    wire.send("b", characters_ns(9), b"ABCDEF")
    wire.heard()
    assert wire.ears["b"].data == Y
    assert wire.ears["a"].data.endswith(b"DEF")  # two characters were one driver's 1 against the other's 0
    assert b"AB" not in wire.ears["a"].data


def test_a_stuck_driver_silences_the_line_and_a_freed_one_does_not():
    wire = Wire("a", "b", "c")
    wire.stations["c"].is_stuck = True
    wire.stations.changed()
    wire.send("a", 0, Y)
    assert wire.heard() == {"a": b"", "b": b"", "c": b""}
    wire.stations["c"].is_stuck = False
    wire.stations.changed()
    wire.send("a", 10**9, Y)
    assert wire.heard()["b"] == Y


def test_a_cut_wire_takes_a_station_off():
    wire = Wire("a", "b", "c")
    wire.stations["c"].is_cut = True
    wire.stations.changed()
    wire.send("a", 0, Y)
    wire.send("c", 10**9, Y)
    assert wire.heard() == {"a": b"", "b": Y, "c": b""}


def test_swapped_wires_are_gibberish_both_ways():
    wire = Wire("a", "b", "c")
    wire.stations["c"].is_swapped = True
    wire.stations.changed()
    wire.send("a", 0, Y)
    assert wire.heard()["b"] == Y
    assert wire.ears["c"].data not in (Y, b"")
    for ear in wire.ears.values():
        ear.got.clear()
    wire.send("c", 10**9, Y)
    wire.heard()
    assert wire.ears["a"].data == wire.ears["b"].data
    assert wire.ears["a"].data != Y


def test_statistics():
    wire = Wire("a", "b")
    told = []
    wire.watchers.append(lambda event: told.append((event.about, event.data)))
    wire.send("a", 0, Y)
    wire.clock.run(0)
    assert told == []  # it is on the line still
    wire.send("b", 10**8, Y[:-3] + b"\3\x65\0")
    wire.send("a", 2 * 10**8, b"noise" + Y)
    wire.clock.run(10**9)
    assert told == [("a", Y), ("b CRC", Y[:-3] + b"\3\x65\0"), ("a noise", b"noise" + Y)]
    stats = wire.stats
    assert (stats.packets, stats.errors, stats.bytes) == (3, {"CRC": 1, "noise": 1}, 7 + 7 + 12)
    assert stats.load(10**9) == pytest.approx((7 + 7 + 12) * 10 / BAUD, abs=1e-6)
    assert (stats.stations["a"].bursts, stats.stations["b"].bytes) == (2, 7)


def test_two_stations_with_one_address_are_said():
    wire = Wire("a", "b", "c")
    for name in "abc":
        wire.set_address(name, 85)
    assert wire.clashes() == {85: ["a", "b", "c"]}
    wire.set_address("b", 86)
    wire.stations.leave("c")
    assert wire.clashes() == {}


DATA = st.binary(min_size=1, max_size=12)


@given(DATA, st.sampled_from([9600, 38400, 250_000, 1_000_000]), st.integers(0, 10**6))
def test_a_lone_driver_is_read_as_it_sent(data, baud, start_ns):
    drive = Driving(start_ns, data, baud, start_ns, start_ns + characters_ns(len(data), baud))
    characters, _ = read(low_line([drive], start_ns, drive.off_ns), baud, start_ns, start_ns, FOREVER)
    assert bytes(each.byte for each in characters) == data
    assert not any(each.is_framing_error for each in characters)
    for index, each in enumerate(characters):
        assert abs(each.at_ns - start_ns - characters_ns(index + 1, baud)) <= 2


@given(DATA)
def test_low_times_are_the_bits(data):
    end_ns = characters_ns(len(data), 1_000_000)
    lows = low_line([Driving(0, data, 1_000_000, 0, end_ns)], 0, end_ns)
    bits = [bit for byte in data for bit in (0, *(byte >> place & 1 for place in range(8)), 1)]
    assert sum(to_ns - from_ns for from_ns, to_ns in lows) == bits.count(0) * 1000


BURSTS = st.lists(
    st.tuples(
        st.sampled_from("abcd"), st.integers(0, 6_000_000), st.sampled_from([Y, b"m", b"\0\2\3", b"U" * 9])
    ),
    max_size=12,
)  # fmt: skip


@given(BURSTS)
def test_whatever_is_sent_every_byte_is_accounted_for_and_in_order(bursts):
    """Any traffic: characters ascend, the line's monitor sees what a tap does, nothing is left open."""
    wire = Wire(*"abcd", "tap")
    free = dict.fromkeys("abcd", 0)
    for name, wanted_ns, data in sorted(bursts, key=lambda burst: burst[1]):
        start_ns = max(wanted_ns, free[name])
        if start_ns > wanted_ns:
            continue  # a UART sends one burst after the other
        free[name] = start_ns + characters_ns(len(data))
        wire.send(name, start_ns, data)
    wire.clock.run(10**10)
    for ear in wire.ears.values():
        times = [at_ns for at_ns, _ in ear.got]
        assert times == sorted(times)
    decoder = PacketDecoder()
    items = decoder.feed(wire.ears["tap"].data)
    good = [item for item in items if not isinstance(item, Malformed)]
    assert len(good) == wire.stats.packets
    assert wire._clean == []
    assert wire._disturbance is None


# ---- packets without CRC through what falsifies packets ----

DATA = st.binary(max_size=8).map(lambda data: bytes(byte for byte in data if byte not in (0, 2, 3)))
PIECES = st.one_of(
    st.sampled_from([b"\0", b"noise", b"\2\x55", b"\2\x55\1m13\3\0\0"]),
    st.builds(lambda data, crc: encode(85, 1, data, crc=crc), DATA, st.booleans()),
)


@given(st.lists(PIECES, max_size=5).map(b"".join), st.integers(0, 2**32))
def test_a_burst_that_no_fault_concerns_goes_out_as_it_is(burst, seed):
    for kind in ("packet_no_ack", "packet_nak"):
        if b"\x06" not in burst:
            assert packet_fault(kind, 1.0, seed)(burst) == burst
    assert packet_fault("packet_bad_crc", 0.0, seed)(burst) == burst


@given(DATA, st.booleans(), st.integers(0, 2**32))
def test_a_spoilt_crc_is_there_and_wrong(data, crc, seed):
    raw = encode(85, 1, data, crc=crc)
    sent = packet_fault("packet_bad_crc", 1.0, seed)(raw)
    [packet] = PacketDecoder().feed(sent)
    assert isinstance(packet, Packet)
    assert (packet.data, packet.is_good, packet.raw) == (data, False, sent)


def test_an_ack_without_crc_becomes_a_nak_without_or_nothing():
    ack = encode(1, 85, b"\x06", crc=False)
    assert packet_fault("packet_nak", 1.0, 1)(ack) == encode(1, 85, b"\x15", crc=False)
    assert packet_fault("packet_no_ack", 1.0, 1)(ack) == b""


@pytest.mark.parametrize("baud", [38400, 1_000_000])
def test_statistics_of_a_line_that_is_not_right_are_read_at_its_own_baud(baud):
    wire = Wire("a", "b", bauds=[baud, baud])
    wire.stations["b"].is_swapped = True
    wire.stations.changed()
    wire.send("a", 0, Y)
    wire.heard()
    assert wire.stats.packets == 1
