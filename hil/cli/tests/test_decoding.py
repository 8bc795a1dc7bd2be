"""Captures as text, by the framing and the speed that each interface names."""

import pytest

from hil.cli.decoding import decoded
from hil.vocab.line_format import FORMATS
from hil.wire.modbus_rtu.frame import encode, silence_ns
from hil.wire.pcapng import CaptureError, Interface, RecordKind, header, read, record
from hil.wire.serial_line import character_ns

ASK, ANSWER = encode(17, 3, b"\0\x6b\0\3"), encode(17, 3, b"\6\2\x2b")
MODBUS = Interface("bus0", "modbus_rtu", 9600)


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
    assert list(decoded(capture)) == [
        "    0.000000 bus0 to 17: read holding registers 107 to 109",
        f"    1.000000 bus0 malformed (gap): {(ASK + bytes((1, 2))).hex(' ')}",
        "    3.000000 bus0 17, function 3: 06 02 2b (function 3 with 4 bytes; it has 5)",
    ]
    assert {each.line for each in read(capture)} == {MODBUS}


def test_a_capture_that_names_no_framing_is_the_sacs() -> None:
    capture = header("test", [Interface("s1")]) + record(0, 5, RecordKind.TX, b"\2\x55\1y\3\x64\0")
    assert list(decoded(capture)) == ["    0.000000 s1 1 -> 85 y"]


def test_a_framing_that_is_not_here_is_said() -> None:
    capture = header("test", [Interface("x", "morse")]) + record(0, 5, RecordKind.TX, b"e")
    with pytest.raises(CaptureError, match="x has the framing 'morse'; this knows sac, modbus_rtu"):
        list(decoded(capture))


def test_what_is_whole_comes_before_the_error() -> None:
    capture = header("test", [MODBUS]) + record(0, 5, RecordKind.RX, ASK) + b"\6\0\0\0"
    lines = decoded(capture)
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
    assert [text.split(" bus0 ")[1] for text in decoded(capture)] == [
        "to 17: read holding registers 107 to 109",
        "from 17: holding registers 107 to 109: 555 0 100",
        "to 17: read holding registers 107 to 109",
        "from 17: function 3: exception 02 (illegal data address)",
        "to all: write holding register 1: 3",
        f"malformed (gap): {(ASK + ASK).hex(' ')}",
    ]
    assert {each.line for each in read(capture)} == {line}
