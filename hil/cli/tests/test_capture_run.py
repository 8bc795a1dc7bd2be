"""Captures as they come: lines, files, their ends, and what is said of them."""

import json
import os
import socket
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest
import typer

from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.socketcan import pack_frame
from bridges.modbus.protocol.frame import encode
from hil.cli.captures.capture_run import Target, capture_run, described
from hil.cli.captures.capture_targets import FileTarget, LinesTarget, WiresharkTarget, chosen_dissectors
from hil.cli.captures.time_order import in_order
from hil.compose.decoding import Decoder, decoded
from hil.wire.pcapng import (
    LINKTYPE_CAN_SOCKETCAN,
    RAW,
    Interface,
    RecordKind,
    frame_record,
    header,
    read,
    record,
)

LINES = [
    Interface("bus0", "sac", 38400),
    Interface("bus1", "modbus_rtu", 9600),
    Interface("can0", baud=1_000_000, link=LINKTYPE_CAN_SOCKETCAN),
    Interface("m1", RAW),
]
PACKET = b"\2\x55\1y\3\x64\0"


def run(sent: bytes, target: Target, count: int | None = None, *, ends: bool = True) -> None:
    """Run a capture of what a bench sends, which then ends the connection or is silent: the one fails."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(sent)
        if ends:
            theirs.shutdown(socket.SHUT_WR)
        with pytest.raises(typer.Exit) if ends and count is None else nullcontext():
            capture_run(ours, target, count, 0.01)


def test_what_passes_is_printed_and_counted(capfd: pytest.CaptureFixture[str]) -> None:
    sent = header("test", LINES) + record(0, 10, RecordKind.RX, PACKET + PACKET)
    sent += record(1, 10**9, RecordKind.RX, encode(17, 3, b"\0\x6b\0\3")[:-1] + b"x")
    sent += frame_record(2, 2 * 10**9, pack_frame(CanFrame(0x705, b"\0")), lost=3)
    sent += record(3, 3 * 10**9, RecordKind.TX, b"p")
    run(sent, LinesTarget(as_json=False))
    out, said = capfd.readouterr()
    assert [line.split(None, 1)[1] for line in out.splitlines()] == [
        "bus0 1 -> 85 y",
        "bus0 1 -> 85 y",
        "bus1 to 17: read holding registers 107 to 109  CRC 76 78 is wrong",
        "can0 705#00               boot-up of 5",
        "m1 client -> board 'p'",
    ]
    assert said.splitlines() == [
        f"hil: capturing {described(LINES)}; Ctrl-C ends it",
        "hil: the bench has ended, and with it the capture: "
        "3 packets, 1 frame, 1 line of bytes, 1 with errors; 3 lost",
    ]
    assert described(LINES[1:]) == "bus1 (modbus_rtu, 9600 baud), can0 (CAN, 1000000 bit/s), m1 (bytes)"


def test_a_frame_that_silence_ends_is_printed_while_nothing_follows(
    capfd: pytest.CaptureFixture[str],
) -> None:
    asked = encode(17, 3, b"\0\x6b\0\3")
    run(header("t", LINES) + record(1, 5, RecordKind.RX, asked), LinesTarget(as_json=True), 1, ends=False)
    row = json.loads(capfd.readouterr().out)
    assert row["to"] == 17
    assert row["data"] == asked.hex()


def test_it_ends_after_so_many(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    sent = header("t", LINES) + b"".join(record(0, at, RecordKind.RX, PACKET) for at in range(9))
    run(sent, LinesTarget(as_json=False), 4, ends=False)
    assert capfd.readouterr().out.count("\n") == 4
    file = tmp_path / "a.pcapng"
    run(sent, FileTarget(str(file), 0, 1), 4, ends=False)
    assert len(list(read(file.read_bytes()))) == 4
    said = capfd.readouterr().err
    assert said.endswith(f"hil: 4 packets; none lost; {file.stat().st_size} bytes in {file}\n")


TALK = [
    (3, 0, RecordKind.TX, b"p\r"),
    (3, 1, RecordKind.RX, b"one\r\ntw"),
    (0, 2, RecordKind.RX, PACKET[:3]),
    (3, 3, RecordKind.RX, b"o\r\nthr"),
    (0, 4, RecordKind.RX, PACKET[3:] + PACKET[:2]),
    (0, 5, RecordKind.LOST, b""),
    (3, 6, RecordKind.RX, b"ee\r\n"),
    (0, 7, RecordKind.RX, PACKET[2:]),
]
"""Lines and packets whose beginnings and ends share records: interface, milliseconds, kind, bytes."""


@pytest.mark.parametrize("count", range(1, 9))
def test_a_file_ends_with_the_last_item_that_counts(count: int, tmp_path: Path) -> None:
    sent = header("t", LINES)
    sent += b"".join(record(line, 10**6 * at, kind, data) for line, at, kind, data in TALK)
    file = tmp_path / "a.pcapng"
    with pytest.raises(typer.Exit) if count == 8 else nullcontext():  # there are seven
        run(sent, FileTarget(str(file), 0, 1), count)
    items = in_order(lambda: decoded(read(file.read_bytes()), Decoder()))
    all_of_it = [item.line(0) for item in in_order(lambda: decoded(read(sent), Decoder()))]
    assert [item.line(0) for item in items] == all_of_it[:count]
    assert len(all_of_it) == 7


def test_items_come_in_the_order_of_time(capfd: pytest.CaptureFixture[str]) -> None:
    """A line that began first ends last; and one record comes long after its time."""
    rows = [
        (3, 0, b"be"),
        (0, 10, PACKET),
        (3, 20, b"gun\n"),
        (0, 15, PACKET),
        (0, 900, PACKET),
        (0, 30, PACKET),
    ]
    sent = header("t", LINES) + b"".join(
        record(line, 10**6 * at, RecordKind.RX, data) for line, at, data in rows
    )
    run(sent, LinesTarget(as_json=False))
    lines = capfd.readouterr().out.splitlines()
    assert [float(line.split()[0]) for line in lines] == [0, 0.01, 0.015, 0.03, 0.9]
    assert lines[0].endswith(r"board -> client 'begun\n'")


def test_a_file_is_whole_where_a_bench_has_ended_in_the_middle(tmp_path: Path) -> None:
    file = tmp_path / "a.pcapng"
    sent = header("t", LINES) + record(0, 1, RecordKind.RX, PACKET)
    run(sent + record(0, 2, RecordKind.RX, PACKET)[:-3], FileTarget(str(file), 0, 1))
    assert file.read_bytes() == sent


def test_wireshark_is_told_of_the_dissector_and_of_canopen() -> None:
    options = chosen_dissectors(LINES[:2])
    assert options[0] == "-X"
    assert Path(options[1].removeprefix("lua_script:")).is_file()
    assert len(options) == 2
    assert chosen_dissectors(LINES)[2:] == ["-d", "can.subdissector,canopen"]


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (
            "[GUI ERROR] -- no Qt platform plugin could be initialized",
            "hil: wireshark has no display to show",
        ),
        ("it is broken", "hil: wireshark ended with exit code 3; it said:\nit is broken\n"),
        ("", "hil: wireshark ended with exit code 3\n"),
    ],
)
def test_why_wireshark_has_not_started(
    said: str,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    program = tmp_path / "wireshark"
    program.write_text(f"#!/bin/sh\necho '{said}' >&2\nexit 3\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(typer.Exit) as ended:
        run(header("t", LINES), WiresharkTarget(), ends=False)
    assert ended.value.exit_code == 1
    told = capfd.readouterr().err.partition("ends it\n")[2]
    assert told.startswith(message)
    assert "Qt" not in told


def test_a_full_disk_is_said(tmp_path: Path) -> None:
    file = tmp_path / "a.pcapng"
    file.write_bytes(header("t", LINES) + record(0, 1, RecordKind.RX, PACKET))
    command = [sys.executable, "-c", "from hil.cli.entry import main; main()", "decode", str(file)]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "hil: the standard output: No space left on device\n")


def test_pcapng_is_refused_for_a_terminal() -> None:
    ours, theirs = os.openpty()
    command = [sys.executable, "-c", "from hil.cli.entry import main; main()", "capture", "a", "b", "-w", "-"]
    with os.fdopen(ours), os.fdopen(theirs):
        done = subprocess.run(command, stdout=theirs, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert "name a file, or write it to a program, as in `hil capture a b -w - | hil decode -`" in done.stderr
