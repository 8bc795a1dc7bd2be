"""Captures as text, by the framing and the speed that each interface names."""

from collections.abc import Iterator

import pytest

from bridges.modbus.protocol.frame import encode
from hil.compose.decoded_item import KEYS, as_lines
from hil.compose.decoding import Decoder, LineChoice, decoded
from hil.vocab.line_format import FORMATS
from hil.wire.pcapng import RAW, CaptureError, Interface, RecordKind, header, read, record
from hil.wire.serial_line import character_ns, silence_ns

ASK, ANSWER = encode(17, 3, b"\0\x6b\0\3"), encode(17, 3, b"\6\2\x2b")
MODBUS = Interface("bus0", "modbus_rtu", 9600)


def lines_of(capture: bytes) -> Iterator[str]:
    return as_lines(decoded(read(capture), Decoder()))


def test_frames_of_modbus_by_the_times_of_their_bursts() -> None:
    late_ns = 10**9 + character_ns(len(ASK), 9600) + silence_ns(9600) - 1
    bursts = [
        (0, ASK[:5]),
        (character_ns(5, 9600), ASK[5:]),
        (10**9, ASK),
        (late_ns, b"\1\2"),
        (3 * 10**9, ANSWER),
    ]
    records = [record(0, at_ns, RecordKind.RX, data) for at_ns, data in bursts]
    capture = header("test", [MODBUS]) + b"".join(records)
    assert list(lines_of(capture)) == [
        "    0.000000 bus0 to 17: read holding registers 107 to 109",
        f"    1.000000 bus0 malformed (gap): {(ASK + bytes((1, 2))).hex(' ')}",
        "    3.000000 bus0 17, function 3: 06 02 2b (function 3 with 4 bytes; it has 5)",
    ]
    assert {each.line for each in read(capture)} == {MODBUS}


PACKET = b"\2\x55\1y\3\x64\0"


def test_a_capture_that_names_no_framing_is_bytes_or_what_is_chosen() -> None:
    capture = header("test", [Interface("s1")]) + record(0, 5, RecordKind.TX, PACKET)
    assert list(lines_of(capture)) == ["    0.000000 s1 02 55 01 79 03 64 00  .U.y.d."]
    chosen = Decoder(choice=LineChoice("sac"))
    assert list(as_lines(decoded(read(capture), chosen))) == ["    0.000000 s1 1 -> 85 y"]


def test_a_framing_that_is_not_here_is_said() -> None:
    capture = header("test", [Interface("x", "morse")]) + record(0, 5, RecordKind.TX, b"e")
    decoder = Decoder()
    assert list(as_lines(decoded(read(capture), decoder))) == ["    0.000000 x 65  e"]
    assert decoder.left_out.told() == "x says 'morse', which is no framing here: shown as bytes (--framing)"


def test_bytes_that_are_no_packet_are_shown_behind_a_silence() -> None:
    line = Interface("bus0", "sac", 9600)
    noise, tail = b"#01RD0 ", PACKET[:3]
    capture = header("test", [line]) + b"".join(
        record(0, at_ns, RecordKind.RX, data)
        for at_ns, data in ((0, noise[:3]), (4 * 10**6, noise[3:]), (10**9, noise), (3 * 10**9, tail))
    )
    items = list(decoded(read(capture), Decoder()))
    assert [(item.at_ns, item.data) for item in items] == [(0, noise), (10**9, noise), (3 * 10**9, tail)]
    assert {item.error for item in items} == {"no packet"}
    assert items[0].say() == "no packet: 23 30 31 52 44 30 20  #01RD0 "


def test_bytes_of_a_line_are_parted_by_silences_and_have_a_longest_length() -> None:
    long = bytes(3000)
    capture = header("test", [Interface("bus0", "bytes", 9600)]) + b"".join(
        record(0, at_ns, RecordKind.RX, data)
        for at_ns, data in ((0, b"ab"), (2 * 10**6, b"c"), (10**7, b"d"), (10**9, long))
    )
    items = list(decoded(read(capture), Decoder()))
    assert [(item.at_ns, item.data) for item in items[:2]] == [(0, b"abc"), (10**7, b"d")]
    assert [len(item.data) for item in items[2:]] == [1024, 1024, 952]
    assert not any(item.error for item in items)


def test_what_is_whole_comes_before_the_error() -> None:
    capture = header("test", [MODBUS]) + record(0, 5, RecordKind.RX, ASK) + b"\6\0\0\0"
    lines = lines_of(capture)
    assert next(lines) == "    0.000000 bus0 to 17: read holding registers 107 to 109"
    with pytest.raises(CaptureError, match="cut off"):
        next(lines)


def test_questions_and_answers_of_modbus_on_a_line_with_parity() -> None:
    line = Interface("bus0", "modbus_rtu", 9600, FORMATS["8E1"])
    frames = [
        ASK,
        encode(17, 3, b"\6\2\x2b\0\0\0\x64"),
        ASK,
        encode(17, 0x83, b"\2"),
        encode(0, 6, b"\0\1\0\3"),
    ]
    times_ns = [at * 10**9 for at in range(len(frames))]
    # A millisecond less than 3.5 characters of eleven bits, and more than 3.5 of ten.
    late_ns = 10**10 + character_ns(8, 9600, 11)
    burst = [(10**10, ASK), (late_ns + 3_800_000, ASK)]
    rows = [*zip(times_ns, frames, strict=True), *burst]
    capture = header("test", [line]) + b"".join(record(0, at, RecordKind.RX, raw) for at, raw in rows)
    assert [text.split(" bus0 ")[1] for text in lines_of(capture)] == [
        "to 17: read holding registers 107 to 109",
        "from 17: holding registers 107 to 109: 555 0 100",
        "to 17: read holding registers 107 to 109",
        "from 17: function 3: exception 02 (illegal data address)",
        "to all: write holding register 1: 3",
        f"malformed (gap): {(ASK + ASK).hex(' ')}",
    ]
    assert {each.line for each in read(capture)} == {line}


def test_bytes_of_a_terminal_by_lines_sides_and_pauses() -> None:
    rows = [
        (0, RecordKind.TX, b"p"),
        (1_000_000, RecordKind.RX, b"step"),
        (2_000_000, RecordKind.RX, b"Number\r"),
        (3_000_000, RecordKind.RX, b"\nrest"),
        (130_000_000, RecordKind.RX, b"later"),
        (131_000_000, RecordKind.TX, b"\xff" * 1500),
    ]
    capture = header("test", [Interface("m1", RAW)]) + b"".join(record(0, *row) for row in rows)
    items = list(decoded(read(capture), Decoder()))
    assert b"".join(item.data for item in items) == b"".join(data for *_, data in rows)
    assert [line[4:50] for line in as_lines(items)] == [
        "0.000000 m1 client -> board 'p'",
        "0.001000 m1 board -> client 'stepNumber\\r\\n'",
        "0.003000 m1 board -> client 'rest'",
        "0.130000 m1 board -> client 'later'",
        "0.131000 m1 client -> board '" + "\\xff" * 4 + "\\",
        "0.131000 m1 client -> board '" + "\\xff" * 4 + "\\",
    ]


def test_packets_for_programs_and_in_red() -> None:
    sac = Interface("bus0", "sac", 38400)
    good, bad = b"\2\x55\1m13\3\0\0", b"\2\0\1y\3\x41\0"
    capture = header("test", [sac, MODBUS]) + record(0, 10, RecordKind.RX, good + bad)
    capture += record(1, 20, RecordKind.RX, ASK) + record(1, 10**9, RecordKind.RX, ASK[:-1] + b"x")
    capture += record(0, 2 * 10**9, RecordKind.LOST, comment="too slow", lost=7)
    decoder = Decoder()
    rows = [item.as_dict(10) for item in decoded(read(capture), decoder)]
    assert decoder.lost == 7
    assert {tuple(row) for row in rows} == {tuple(KEYS)}
    parts = ("source", "kind", "from", "to", "error")
    assert [tuple(row[name] for name in parts) for row in rows] == [
        ("bus0", "packet", 1, 85, None),
        ("bus0", "packet", 1, "all", "CRC"),
        ("bus0", "packet", None, 17, None),
        ("bus0", "packet", None, 17, "CRC"),
        ("bus0", "event", None, None, "lost"),
    ]
    assert rows[0]["data"] == (good[:-1]).hex()
    items = list(decoded(read(capture), Decoder()))
    assert items[1].line(0, colours=True).startswith("\x1b[31m")
    assert items[0].line(0, colours=True) == items[0].line(0)


def test_names_and_comments_do_nothing_to_a_terminal() -> None:
    line = Interface("a\x1b[2Jb", "sac")
    capture = header("test", [line]) + record(0, 1, RecordKind.FRAMING_ERROR, b"x", "by\r\x9b1mme")
    (text,) = lines_of(capture)
    assert text.isprintable()
    assert r"a\x1b[2Jb framing error (by\r\x9b1mme): 78" in text


def test_bytes_of_two_senders_are_two_items_and_say_whose_they_are() -> None:
    capture = header("test", [Interface("bus0", "bytes", 9600)]) + b"".join(
        record(0, at_ns, RecordKind.RX, data, by)
        for at_ns, data, by in (
            (0, b"#0", "bus0.a"),
            (2 * 10**6, b"1", "bus0.a"),
            (4 * 10**6, b">", "bus0.b"),
        )
    )
    assert list(lines_of(capture)) == [
        "    0.000000 bus0 bus0.a: 23 30 31  #01",
        "    0.004000 bus0 bus0.b: 3e  >",
    ]
