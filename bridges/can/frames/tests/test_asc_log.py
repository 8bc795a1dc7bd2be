"""Vector's text logs as several programs write them, and what is in them beside frames of classic CAN."""

import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.can.frames.asc_log import read_asc
from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.candump_log import LoggedFrame
from bridges.can.frames.socketcan import CanError
from hil.wire.outside_text import LeftOut, lines_of

HEADER = """date Thu Apr 28 10:44:52.480 am 2022
base hex  timestamps absolute
internal events logged
// version 9.0.0
//0.000000 previous log file: x.asc
Begin Triggerblock Thu Apr 28 10:44:52.480 am 2022
   0.000000 Start of measurement
"""
FD = "a frame of CAN FD; this reads classic CAN"


def read(text: str) -> tuple[list[LoggedFrame], str]:
    left_out = LeftOut()
    return list(read_asc(lines_of(text), left_out)), left_out.told()


def frames(text: str) -> list[CanFrame | CanError]:
    return [row.frame for row in read(HEADER + text)[0]]


def times_s(text: str) -> list[float]:
    return [row.at_ns / 1e9 for row in read(text)[0]]


@pytest.mark.parametrize(
    ("line", "frame"),
    [
        ("0.1 1  181             Rx   d 2 6A 00", CanFrame(0x181, b"\x6a\0")),
        (
            "0.1 1  16A954A6x  Tx  d 1 FF  Length = 2 BitCount = 3 ID = 380195006x",
            CanFrame(380195006, b"\xff", True),
        ),
        ("0.1 1  16A954A6X       Tx   d 0", CanFrame(0x16A954A6, b"", True)),
        ("0.1 1  0x123           Rx   d 1 07", CanFrame(0x123, b"\7")),
        ("0.1 1  0x              Rx   d 1 07", CanFrame(0, b"\7", True)),
        ("0.1 1  181             Rx   r", CanFrame(0x181, b"", False, True)),
        ("0.1 1  181             Rx   r 8", CanFrame(0x181, b"", False, True, 8)),
        ("0.1 1  181             Rx   r Length = 0 BitCount = 0 ID = 385", CanFrame(0x181, b"", False, True)),
        ("0.1 1  181             Rx   d f 1 2 3 4 5 6 7 8", CanFrame(0x181, bytes(range(1, 9)))),
        ("0.1 1  ErrorFrame", CanError("")),
        ("0.1 1  ErrorFrame  ECC: 10100010", CanError("")),
        ("0.1 1 ErrorFrame  Flags = 0xe CodeExt = 0x20a2 Code = 0x82 ID = 0 DLC = 0", CanError("")),
        ("0.1 1  Heartbeat5      Rx   d 1 05  Length = 0 BitCount = 0 ID = 1797", CanFrame(0x705, b"\5")),
        ("0.1 1  AB              Rx   d 1 05  Length = 0 BitCount = 0 ID = 1797", CanFrame(0x705, b"\5")),
        (
            "0.1 1  Engine_1  Rx   d 1 05  Length = 0 BitCount = 0 ID = 380195006x",
            CanFrame(380195006, b"\5", True),
        ),
        ("0.1 1  705             Rx   d 1 05  Length = 0 BitCount = 0 ID = 0", CanFrame(0x705, b"\5")),
        ("0,1 1  705             Rx   d 1 05", CanFrame(0x705, b"\5")),
        ("0.1 CANFD   1 Rx        705         0 0 1  1 05   0  0 0 0 0 0 0 0", CanFrame(0x705, b"\5")),
        (
            "0.1 CANFD   1 Tx   1ABCDEF0x  Name  0 0 2  2 05 06   130000  130        0 0 0 0 0 0",
            CanFrame(0x1ABCDEF0, b"\5\6", True),
        ),
        (
            "0.1 CANFD   1 Rx        123         0 0 4  0   130000  130       10 0 0 0 0 0",
            CanFrame(0x123, b"", False, True, 4),
        ),
        ("0.1 CANFD   1 Rx   ErrorFrame   Not Acknowledge error  fffe c7 31ca", CanError("")),
    ],
)  # fmt: skip
def test_lines_of_frames(line: str, frame: CanFrame | CanError) -> None:
    assert read(f"{HEADER}   {line}\nEnd TriggerBlock\n") == ([LoggedFrame(100_000_000, "can0", frame)], "")


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("0.1 1  181 TxRq d 2 6A 00", "a request to send (TxRq), whose frame follows"),
        ("0.1 CANFD 1 TxRq 181 0 0 1 1 05 0 0 0 0 0 0 0 0", "a request to send (TxRq), whose frame follows"),
        ("0.1 1 J1939TP FEE3p 6 0 0 - Rx d 23 A0", "a message of J1939's transport, whose frames are there"),
        ("0.1 CANFD 1 Rx 300 Name 1 0 f 64 " + "00 " * 64 + "0 0 3000 0 0 0 0 0", FD),
        ("0.1 CANFD 1 Rx 300 0 0 8 8 01 02 03 04 05 06 07 08 130 130 1000 0 0 0 0 0", FD),
        ("0.1 1  Name Rx d 1 05", "'Name' is no identifier: save the log with numbers in place of names"),
        ("0.1 1  181 Rx d 8 01 02", "2 bytes of data, where the frame says 8"),
        ("0.1 1  181 Rx d 2 01 GG", "'GG' is no number of 0 to 255"),
        ("0.1 1  181 Rx d 2 01 1FF", "'1FF' is no number of 0 to 255"),
        ("0.1 1  FFFFFFFFx Rx d 0", "identifier FFFFFFFF has more than 29 bits"),
        ("0.1 Li 33 Rx 8 00 00 00 00", "an event of 'Li', which is no CAN bus"),
        ("0.1 1  181", "'1  181' is no frame"),
        ("0.1 1", "'1' is no frame"),
    ],
)  # fmt: skip
def test_what_is_no_frame_of_classic_can_is_left_out_and_said(line: str, why: str) -> None:
    rows, said = read(f"{HEADER}{line}\n0.2 1 705 Rx d 1 05\n")
    assert [row.frame for row in rows] == [CanFrame(0x705, b"\5")]
    assert said == f"1 left out: line 8: {why}"


def test_events_that_are_no_frames_say_nothing() -> None:
    events = """
   0.015991 CAN 1 Status:chip status error passive - TxErr: 132 RxErr: 0
   1.015991 1  Statistic: D 3 R 0 XD 0 XR 0 E 0 O 0 B 0.01%
   1.1 log trigger event
   1.1 log direct start (0ms)
   1.2 Comment: a word
   1.3 SV: 2 0 1 ::Env::x = 1
"""
    assert read(HEADER + events) == ([], "")


def test_times_that_count_from_the_line_before_are_added_up() -> None:
    relative = HEADER.replace("absolute", "relative")
    lines = "0.1 1 181 Rx d 0\n0.1 1 Statistic: D 1\n0.1 1 182 TxRq d 0\n0.3 1 182 Tx d 0\n"
    assert times_s(relative + lines) == [0.1, 0.6]
    assert times_s(HEADER + lines) == [0.1, 0.3]


def test_a_file_without_trigger_blocks_loses_no_frame() -> None:
    busmaster = "date Mon Dec 6 11:21:13 am 2021\nbase hex  no internal events logged\n// version 7.1.0\n"
    rows, said = read(busmaster + "40874.808200 1 122 Rx d 2 E3 0C\n40874.8091 2 3E5 Rx d 1 E6\n")
    assert rows == [
        LoggedFrame(40_874_808_200_000, "can0", CanFrame(0x122, b"\xe3\x0c")),
        LoggedFrame(40_874_809_100_000, "can1", CanFrame(0x3E5, b"\xe6")),
    ]
    assert not said
    assert len(read("0.1 1 122 Rx d 1 05\n")[0]) == 1, "it has no header at all"


def test_numbers_may_be_decimal() -> None:
    text = HEADER.replace("hex", "dec") + "0.1 1 181 Rx d 3 10 255 0\n0.1 1 380195006x Rx d 1 16\n"
    assert [row.frame for row in read(text)[0]] == [
        CanFrame(181, b"\x0a\xff\0"),
        CanFrame(380195006, b"\x10", True),
    ]


def test_a_text_that_is_no_log_gives_nothing_and_says_it() -> None:
    rows, said = read("-----BEGIN PGP SIGNATURE-----\niQEzBAAB\n")
    assert rows == []
    assert said == "2 left out: line 1 '-----BEGIN PGP SIGNATURE-----' and 1 more: no line of such a log"


@pytest.mark.skipif(not shutil.which("log2asc"), reason="needs can-utils")
@pytest.mark.parametrize("options", [[], ["-4"], ["-n"], ["-f"], ["-r"]])
def test_what_can_utils_make_of_a_log_is_the_same(options: list[str], tmp_path: Path) -> None:
    log = tmp_path / "a.log"
    log.write_text(
        "(1.000000) can0 123#0011\n(1.100000) can1 1ABCDEF0#0011223344556677\n(1.200000) can0 123#R\n"
    )
    command = ["log2asc", *options, "-I", str(log), "can0", "can1"]
    made = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert [(row.bus, row.frame) for row in read(made)[0]] == [
        ("can0", CanFrame(0x123, b"\0\x11")),
        ("can1", CanFrame(0x1ABCDEF0, bytes.fromhex("0011223344556677"), True)),
        ("can0", CanFrame(0x123, b"", False, True)),
    ]


EVENTS = "1 2 CANFD Rx TxRq d r 8 FF 0x x ErrorFrame ID = 1797 base hex 0.1 // Name 123x"
WORDS = st.sampled_from(EVENTS.split(" "))


@given(st.lists(st.one_of(st.text(max_size=40), st.lists(WORDS, max_size=9).map(" ".join)), max_size=6))
def test_any_text_is_read(lines: list[str]) -> None:
    left_out = LeftOut()
    rows = list(read_asc([*HEADER.split("\n"), *(f"0.5 {line}" for line in lines), *lines], left_out))
    assert left_out.told().isprintable()
    assert len(rows) <= 2 * len(lines)
