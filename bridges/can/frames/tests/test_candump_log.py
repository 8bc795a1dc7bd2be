"""What candump writes in all its ways, and lines that are no frames of classic CAN among them."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.candump_log import LoggedFrame, is_candump_line, read_candump
from bridges.can.frames.socketcan import CanError
from hil.wire.outside_text import LeftOut

EIGHT = bytes(range(8))


def read(*lines: str) -> tuple[list[LoggedFrame], str]:
    left_out = LeftOut()
    return list(read_candump(lines, left_out)), left_out.told()


@pytest.mark.parametrize(
    ("line", "frame"),
    [
        ("  can0  123   [2]  00 11", CanFrame(0x123, b"\0\x11")),
        ("can0  123   [0] ", CanFrame(0x123)),
        ("  vcan0  1ABCDEF0   [8]  00 01 02 03 04 05 06 07", CanFrame(0x1ABCDEF0, EIGHT, True)),
        ("  can0  00000123   [1]  05", CanFrame(0x123, b"\5", True)),
        ("  can0  123   [4]  remote request", CanFrame(0x123, b"", False, True, 4)),
        ("  can0  123   {E}  00 01 02 03 04 05 06 07", CanFrame(0x123, EIGHT)),
        ("  can0  123   [3]  41 42 00                  'AB.'", CanFrame(0x123, b"AB\0")),
        ("  can0  RX - -  123   [1]  05", CanFrame(0x123, b"\5")),
        ("  can0  20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME", CanError("")),
        ("  can0  20000040   [8]  00 00 00 00 00 00 00 00   ERRORFRAME", CanError("bus-off")),
        ("\x1b[32m  can0  123   [1]  05\x1b[0m", CanFrame(0x123, b"\5")),
        ("can0 123#0011", CanFrame(0x123, b"\0\x11")),
    ],
)
@pytest.mark.parametrize(
    ("time", "at_ns"),
    [
        ("", 0),
        (" (1700000000.000123) ", 1_700_000_000_000_123_000),
        (" (000.000123) ", 123_000),
        (" (1970-01-02 00:00:01.500000) ", 86_401_500_000_000),
        (" (1700000000.000000001) ", 1_700_000_000_000_000_001),
    ],
)
def test_lines_of_a_terminal(time: str, at_ns: int, line: str, frame: CanFrame | CanError) -> None:
    assert is_candump_line(time + line)
    bus = "vcan0" if "vcan0" in line else "can0"
    assert read(time + line) == ([LoggedFrame(at_ns, bus, frame)], "")


@pytest.mark.parametrize(
    ("line", "frame"),
    [
        ("(1.0) can0 123#0001020304050607_E", CanFrame(0x123, EIGHT)),
        ("(1.0) can0 123#R8_F", CanFrame(0x123, b"", False, True, 8)),
        ("(1.0) can0 123#R", CanFrame(0x123, b"", False, True)),
        ("(1.0) can0 123#00 T", CanFrame(0x123, b"\0")),
        ("(1.0) can0 123#00 R\r", CanFrame(0x123, b"\0")),
        ("(1.0)  can0  20000040#0000000000000000", CanError("bus-off")),
    ],
)
def test_lines_of_a_log(line: str, frame: CanFrame | CanError) -> None:
    assert read(line) == ([LoggedFrame(10**9, "can0", frame)], "")


def test_what_is_no_frame_of_classic_can_is_left_out_counted_and_ends_nothing() -> None:
    rows, said = read(
        "(1.0) can0 123##1112233",
        "(1.1) can0 705#05",
        "  can0  123  [12]  00 11 22 33 44 55 66 77 88 99 AA BB",
        "(1.2) can0 123##3",
        "DROPCOUNT: dropped 12 CAN frames on 'can0' socket (total drops 12)",
        "  can0  20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME",
        "\tcontroller-problem{rx-error-warning}",
        "(1.3) can0 706#05",
    )
    assert [row.frame for row in rows] == [CanFrame(0x705, b"\5"), CanError(""), CanFrame(0x706, b"\5")]
    assert said == (
        "4 left out: line 1 and 2 more: a frame of CAN FD; this reads classic CAN; line 5"
        " \"DROPCOUNT: dropped 12 CAN frames on 'can0' socket (total dro\":"
        " no line of candump's, as in (1.000123) can0 123#0011"
    )


def test_differences_are_added_up_and_times_since_the_first_frame_are_not() -> None:
    frames = "  can0  {}   [1]  05"
    lines = [
        f" ({at}) {frames.format(f'70{n}')}"
        for n, at in enumerate(("000.000000", "000.100000", "000.100000"))
    ]
    rows, said = read(*lines)
    assert [row.at_ns for row in rows] == [0, 10**8, 2 * 10**8]
    assert said == "its times are differences (candump -td), and were added up"
    assert [row.at_ns for row in read(*lines[:2])[0]] == [0, 10**8]
    two_buses = [lines[0], lines[1], lines[2].replace("can0", "can1")]
    assert [row.at_ns for row in read(*two_buses)[0]] == [0, 10**8, 10**8]


@pytest.mark.parametrize(
    ("times", "at_us"),
    [
        ((0, 100, 200, 200, 300), (0, 100, 200, 200, 300)),
        ((0, 0, 100), (0, 0, 100)),
        ((0, 0), (0, 0)),
        ((0, 100, 200, 150), (0, 100, 300, 450)),
        ((0, 100, 100, 100), (0, 100, 200, 300)),
    ],
)
def test_frames_of_one_time_are_no_differences(times: Sequence[int], at_us: Sequence[int]) -> None:
    rows, said = read(*(f" (000.{us:06})  can0  701   [1]  05" for us in times))
    assert [row.at_ns // 1000 for row in rows] == [*at_us]
    assert bool(said) == (at_us != times)


@given(st.lists(st.text(max_size=60), max_size=5))
def test_any_text_is_read(lines: list[str]) -> None:
    rows, said = read(*lines)
    assert said.isprintable()
    assert len(rows) <= len(lines)
