"""Captures as text, by the framing and the speed that each interface names."""

import pytest

from hil.cli.decoding import decoded
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
        "    0.000000 bus0 17, function 3: 00 6b 00 03",
        f"    1.000000 bus0 malformed (gap): {(ASK + bytes((1, 2))).hex(' ')}",
        "    3.000000 bus0 17, function 3: 06 02 2b",
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
    assert next(lines) == "    0.000000 bus0 17, function 3: 00 6b 00 03"
    with pytest.raises(CaptureError, match="cut off"):
        next(lines)
