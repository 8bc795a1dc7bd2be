"""Captures of a segment: live, rotated, decoded, dissected, played again."""

import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from e2e_support import HIL, PATIENCE_S, SAC_READY_NS, Client, Place, config, until

from device_profiles.sac.packet import encode

LUA = Path(__file__).parent.parent / "wireshark" / "sac_packets.lua"
SAC: dict[str, Any] = {"profile": "sac", "flash": {}}
ONE = config(
    speed=5, devices={"s1": SAC}, segments={"bus0": {"stations": ["s1"], "taps": {"master": {}, "other": {}}}}
)
needs_tshark = pytest.mark.skipif(not shutil.which("tshark"), reason="needs tshark")


def hil(place: Place, *arguments: str, where: bool = True) -> subprocess.CompletedProcess[str]:
    command = [HIL, *arguments, *(["--runtime-dir", str(place.runtime)] if where else [])]
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)


class Captured:
    """A capture of bus0 while it is in the block."""

    def __init__(self, place: Place, server: Any, *options: str) -> None:
        self.path = place.folder / "bus0.pcapng"
        self._command = [HIL, "capture", "bus0", "-w", str(self.path), *options]
        self._command += ["--runtime-dir", str(place.runtime)]
        self._server = server

    def __enter__(self) -> "Captured":
        self._process = subprocess.Popen(self._command)
        until(lambda: self.path.exists() and self.path.stat().st_size > 0, "the capture's beginning")
        return self

    def wait_for(self, text: str) -> str:
        """Wait until the decoded capture ends with a text, and return all of it."""

        def decoded() -> str:
            out = subprocess.run([HIL, "decode", str(self.path)], capture_output=True, text=True).stdout
            return out if out.endswith(text) else ""

        return until(decoded, f"{text!r} in the capture")

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.wait(PATIENCE_S)


@pytest.fixture
def server(place: Place) -> Any:
    server = place.serve(ONE)
    server.ready(boot_ns=SAC_READY_NS)
    return server


def talk(place: Place) -> None:
    with Client(str(place.runtime / "t" / "bus0.master")) as master:
        for data, answer in ((b"v150", b"\x06"), (b" hi \x7f", b"\x06")):
            master.write(encode(85, 1, data))
            assert master.read_exactly(7) == encode(1, 85, answer)
        master.write(encode(85, 1, b"m9")[:-2] + b"\x41\0")
        assert master.read_exactly(7) == encode(1, 85, b"\x15")
        master.write(b"\2\x55\1y\0" + encode(0, 1, b"y"))


def test_a_capture_as_text_and_again_on_the_wire(place: Place, server: Any) -> None:
    with Captured(place, server) as captured:
        talk(place)
        text = captured.wait_for("bus0 1 -> all y\n")
    lines = [line.split(" ", 1)[1] for line in (row.strip() for row in text.splitlines())]
    assert lines == [
        "bus0 1 -> 85 v150",
        "bus0 85 -> 1 ACK",
        r"bus0 1 -> 85  hi \x7f",
        "bus0 85 -> 1 ACK",
        "bus0 1 -> 85 m9  CRC 41 is wrong",
        "bus0 85 -> 1 NAK",
        "bus0 malformed (no ETX): 02 55 01 79 00",
        "bus0 1 -> all y",
    ]
    before = server.ask("segments")[0]["packets"]
    played = hil(place, "play", str(captured.path), "bus0.other")
    assert played.stdout.startswith("7 bursts begin now"), played
    until(lambda: server.ask("segments")[0]["packets"] >= before + 7, "the capture on the wire")
    assert hil(place, "play", str(captured.path), "bus0.none").returncode == 1
    assert hil(place, "play", str(captured.path), "bus0.other", "--source", "x").returncode == 1


def talk_without_crc(place: Place) -> None:
    """m13, whose CRC is 0, ends with NUL twice, the others with one."""
    with Client(str(place.runtime / "t" / "bus0.master")) as master:
        for raw in (encode(85, 1, b"m13"), encode(85, 1, b"v150", crc=False)):
            master.write(raw)
            assert master.read_exactly(7) == encode(1, 85, b"\x06")
        master.write(b"\2\x56\1v90\3\0\0" + encode(0, 1, b"y", crc=False))


def test_packets_without_crc_in_a_capture(place: Place, server: Any) -> None:
    with Captured(place, server) as captured:
        talk_without_crc(place)
        text = captured.wait_for("bus0 1 -> all y\n")
    assert [
        row.split(" ", 2)[2] for row in (row.strip() for row in text.splitlines()) if "ACK" not in row
    ] == [
        "1 -> 85 m13",
        "1 -> 85 v150",
        "1 -> 86 v90",
        "1 -> all y",
    ]
    assert server.ask("segments")[0]["errors"] == {}


def test_a_capture_that_is_cut_off_is_read_up_to_there(place: Place, server: Any) -> None:
    with Captured(place, server) as captured:
        talk(place)
        captured.wait_for("bus0 1 -> all y\n")
    cut = place.folder / "cut.pcapng"
    cut.write_bytes(captured.path.read_bytes()[:-5])
    decoded = hil(place, "decode", str(cut), where=False)
    assert decoded.returncode == 1
    assert decoded.stdout.count("\n") == 6
    assert "cut off in the middle of a block at byte " in decoded.stderr
    cut.write_bytes(b"no capture at all")
    assert "this is no pcapng file" in hil(place, "decode", str(cut), where=False).stderr
    assert hil(place, "decode", "/not/there", where=False).returncode == 2


def test_rotated_files_are_whole(place: Place, server: Any) -> None:
    with Captured(place, server, "--rotate", "0.001", "--files", "2") as captured:
        for _ in range(10):
            talk(place)
        until(lambda: not captured.path.exists(), "the oldest file's end")
    kept = sorted(place.folder.glob("bus0*.pcapng"))
    assert len(kept) == 2
    assert captured.path not in kept
    for path in kept:
        assert hil(place, "decode", str(path), where=False).returncode == 0
        assert path.stat().st_size <= 1000


@needs_tshark
def test_tshark_shows_the_packets(place: Place, server: Any) -> None:
    with Captured(place, server) as captured:
        talk(place)
        captured.wait_for("bus0 1 -> all y\n")
    fields = ["-T", "fields", "-e", "sacnet.destination", "-e", "sacnet.origin", "-e", "sacnet.data"]
    fields += ["-e", "sacnet.crc_ok", "-e", "_ws.col.Info"]
    command = ["tshark", "-X", f"lua_script:{LUA}", "-r", str(captured.path), *fields]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=2 * PATIENCE_S)
    rows = [line.split("\t") for line in shown.stdout.splitlines()]
    assert [row[:4] for row in rows[:6]] == [
        ["85", "1", "v150", "1"],
        ["1", "85", "ACK", "1"],
        ["85", "1", rows[2][2], "1"],
        ["1", "85", "ACK", "1"],
        ["85", "1", "m9", "0"],
        ["1", "85", "NAK", "1"],
    ], shown
    assert rows[0][4] == "1 -> 85 v150"
    assert "CRC is wrong" in rows[4][4]
    assert "malformed" in rows[6][4]


@needs_tshark
def test_tshark_shows_packets_without_crc(place: Place, server: Any) -> None:
    with Captured(place, server) as captured:
        talk_without_crc(place)
        captured.wait_for("bus0 1 -> all y\n")
    command = [
        "tshark",
        "-X",
        f"lua_script:{LUA}",
        "-r",
        str(captured.path),
        "-T",
        "fields",
        "-e",
        "_ws.col.Info",
    ]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=2 * PATIENCE_S)
    rows = [row for row in shown.stdout.splitlines() if "ACK" not in row]
    assert rows == ["1 -> 85 m13", "1 -> 85 v150", "1 -> 86 v90, 1 -> all y"], shown


@needs_tshark
def test_a_live_capture_goes_into_tshark(place: Place, server: Any) -> None:
    capture = [HIL, "capture", "bus0", "-w", "-", "--runtime-dir", str(place.runtime)]
    show = ["tshark", "-l", "-i", "-", "-c", "2", "-T", "fields", "-e", "data.data"]
    with (
        subprocess.Popen(capture, stdout=subprocess.PIPE) as writer,
        subprocess.Popen(show, stdin=writer.stdout, stdout=subprocess.PIPE, text=True) as reader,
    ):
        until(lambda: writer.poll() is None, "the capture")
        # tshark needs its time to start; the wire is quiet until it has the header.
        until(lambda: server.ask("segments") and _talked(place, reader), "two packets in tshark", 60)
        writer.terminate()


def _talked(place: Place, reader: subprocess.Popen[str]) -> bool:
    talk(place)
    return reader.poll() is not None
