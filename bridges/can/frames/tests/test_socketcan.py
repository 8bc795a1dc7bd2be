"""Frames and errors as Linux has them, candump's logs, and captures of CAN in pcapng."""

import contextlib
import os
import random
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.can.frames.can_frame import CanFrame, parse_frame
from bridges.can.frames.candump_log import LoggedFrame, candump_line, read_candump
from bridges.can.frames.socketcan import CanError, SocketCanError, pack_error, pack_frame, unpack
from hil.wire.outside_text import LeftOut
from hil.wire.pcapng import (
    LINKTYPE_CAN_SOCKETCAN,
    CaptureError,
    Interface,
    bursts,
    frame_record,
    header,
    read,
)

KINDS = (
    *("bit", "form", "stuff", "CRC", "acknowledgement"),
    *("error-active", "error-passive", "bus-off", "frames lost"),
)


@st.composite
def frames(draw: st.DrawFn) -> CanFrame:
    is_extended, is_remote = draw(st.booleans()), draw(st.booleans())
    identifier = draw(st.integers(0, 0x1FFFFFFF if is_extended else 0x7FF))
    if is_remote:
        return CanFrame(identifier, b"", is_extended, True, draw(st.integers(0, 8)))
    return CanFrame(identifier, draw(st.binary(max_size=8)), is_extended)


@given(frames())
def test_a_frame_is_the_same_behind_it(frame: CanFrame) -> None:
    assert unpack(pack_frame(frame)) == frame
    assert unpack(pack_frame(frame) + bytes(4)) == frame, "the kernel pads to 16 bytes"
    assert parse_frame(str(frame)) == frame
    logged = LoggedFrame(1_500_000_000, "can0", frame)
    assert candump_line(logged) == f"(1.500000) can0 {frame}"
    assert list(read_candump([f"(1.5) can0 {frame}"], LeftOut())) == [logged]


@pytest.mark.parametrize("kind", KINDS)
def test_an_error_is_the_same_behind_it(kind: str) -> None:
    assert unpack(pack_error(kind)) == CanError(kind)
    logged = LoggedFrame(1_700_000_000_000_001_000, "can0", CanError(kind))
    assert list(read_candump([candump_line(logged)], LeftOut())) == [logged]


@pytest.mark.parametrize(
    ("payload", "why"),
    [
        (b"", "0 bytes are no CAN frame"),
        (bytes(7), "7 bytes are no CAN frame"),
        (struct.pack(">IBBBB", 0x123, 9, 0, 0, 0) + bytes(9), "CAN FD"),
        (struct.pack(">IBBBB", 0x123, 3, 4, 0, 0) + bytes(3), "CAN FD"),
        (struct.pack(">IBBBB", 0x123, 3, 0, 0, 0) + bytes(2), "2 bytes of data, where the frame says 3"),
        (struct.pack(">IBBBB", 0x800, 0, 0, 0, 0), "identifier 800 has more than 11 bits"),
    ],
)
def test_what_is_no_frame_is_refused(payload: bytes, why: str) -> None:
    with pytest.raises(SocketCanError, match=why):
        unpack(payload)


@given(st.binary(max_size=24))
def test_any_bytes_are_a_frame_or_refused(payload: bytes) -> None:
    with contextlib.suppress(SocketCanError):
        assert isinstance(unpack(payload), CanFrame | CanError)


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("123#00", "no line of candump's"),
        ("(1.0) can0 12#00", "no frame; write three or eight digits"),
        ("(1.0) can0 800#00", "more than 11 bits; write 8 digits for 29"),
        ("(1.0) can0 80000000#00", "more than 29 bits"),
        ("(1.0) can0 123##100", "CAN FD"),
        ("(1.0) can0 123#0", "two digits for each"),
        ("(1.0) can0 123#001122334455667788", "two digits for each of 0 to 8 bytes"),
        ("(1.0) can0 123#R9", "R or R0 to R8"),
        ("(1.0) can0 123#" + "0" * 1000, "no line of candump's"),
    ],
)
def test_a_line_that_is_wrong_is_left_out_with_its_number(line: str, why: str) -> None:
    left_out = LeftOut()
    rows = ["(0.000001) can0 001#", "(0.25) can0 123#R T", "", line, "(0.5) can0 002#"]
    assert list(read_candump(rows, left_out)) == [
        LoggedFrame(1000, "can0", CanFrame(1)),
        LoggedFrame(250_000_000, "can0", CanFrame(0x123, is_remote=True)),
        LoggedFrame(500_000_000, "can0", CanFrame(2)),
    ]
    assert left_out.told().startswith("1 left out: line 4")
    assert why in left_out.told()


CAN0 = Interface("can0", baud=500_000, link=LINKTYPE_CAN_SOCKETCAN)


def test_a_capture_of_a_bus_and_a_line() -> None:
    frame = pack_frame(CanFrame(0x701, b"\x7f"))
    data = header("hil", [Interface("bus0", "sac", 9600), CAN0]) + frame_record(
        1, 5_000_000_007, frame, "m1.canopen"
    )
    (record,) = read(data)
    assert record.line == CAN0
    assert (record.at_ns, record.data, record.comment) == (5_000_000_007, frame, "m1.canopen")
    with pytest.raises(CaptureError, match="it has frames of CAN alone; canplayer"):
        bursts(read(data), None)


def test_fuzz_mutated_captures_and_lines_are_read_or_refused() -> None:
    """``HIL_FUZZ`` records and lines."""
    chance = random.Random(int(os.environ.get("HIL_FUZZ_SEED", "1")))
    capture = header("hil", [CAN0]) + frame_record(0, 7, pack_frame(CanFrame(1, b"ab")), "x") * 2
    line = b"(1700000000.000123) can0 1ABCDEF0#0011AAff R"
    for _ in range(int(os.environ.get("HIL_FUZZ", "20000")) // 2):
        for good in (capture, line):
            mutated = bytearray(good)
            for _ in range(chance.randint(1, 4)):
                mutated[chance.randrange(len(good))] = chance.randrange(256)
            with contextlib.suppress(CaptureError):
                if good is line:
                    list(read_candump([mutated.decode("utf-8", "replace")], LeftOut()))
                else:
                    list(read(bytes(mutated[: chance.randint(0, 2 * len(good))])))


@given(st.data())
def test_a_mutated_capture_is_read_or_refused(data: st.DataObject) -> None:
    good = header("hil", [CAN0]) + frame_record(0, 7, pack_frame(CanFrame(1, b"ab")), "x") * 2
    mutated = bytearray(good)
    for _ in range(data.draw(st.integers(1, 4))):
        mutated[data.draw(st.integers(0, len(good) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(good)))
    with contextlib.suppress(CaptureError):
        list(read(bytes(mutated[:cut])))
