"""Captures of a segment: live, rotated, decoded, dissected, played again."""

import json
import os
import re
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
    assert hil(place, "play", str(captured.path), "bus0.none").returncode == 2
    assert hil(place, "play", str(captured.path), "bus0.other", "--source", "x").returncode == 2


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


@pytest.mark.thorough
def test_a_capture_that_is_cut_off_is_read_up_to_there(place: Place, server: Any) -> None:
    with Captured(place, server) as captured:
        talk(place)
        captured.wait_for("bus0 1 -> all y\n")
    cut = place.folder / "cut.pcapng"
    cut.write_bytes(captured.path.read_bytes()[:-5])
    decoded = hil(place, "decode", str(cut), where=False)
    assert decoded.returncode == 2
    assert decoded.stdout.count("\n") == 6
    assert "cut off in the middle of a block at byte " in decoded.stderr
    cut.write_bytes(b"no capture at all")
    assert "this is no capture (pcapng, pcap)" in hil(place, "decode", str(cut), where=False).stderr
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
def test_wireshark_is_started_with_live_packets_and_the_dissector(place: Place, server: Any) -> None:
    """tshark in Wireshark's place."""
    shown, program = place.folder / "shown", place.folder / "bin" / "wireshark"
    program.parent.mkdir()
    program.write_text(
        '#!/bin/sh\n[ "$1" = -k ] || exit 9\nshift\n'
        f'exec tshark -l -c 2 -T fields -e _ws.col.Info "$@" >{shown} 2>/dev/null\n'
    )
    program.chmod(0o755)
    command = [HIL, "capture", "bus0", "--wireshark", "--runtime-dir", str(place.runtime)]
    env = os.environ | {"PATH": f"{program.parent}:{os.environ['PATH']}"}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=env) as capture:
        # tshark needs its time to start; the wire is quiet until it has the header.
        until(lambda: _talked(place, capture), "the end of tshark", 60)
        assert capture.returncode == 0
        assert capture.stderr
        assert " bytes to wireshark\n" in capture.stderr.read()
    # The first two packets that it has seen, wherever in the talk it began.
    assert all(re.match(r"(malformed, )?\d+ -> (\d+|all) ", row) for row in shown.read_text().splitlines())
    assert shown.stat().st_size
    missing = subprocess.run(command, capture_output=True, text=True, env=env | {"PATH": "/nowhere"})
    assert missing.returncode == 1
    assert "wireshark is not installed: install it (Debian: apt install wireshark)" in missing.stderr


def _talked(place: Place, reader: subprocess.Popen[str]) -> bool:
    talk(place)
    return reader.poll() is not None


SCRIPT = """
"$@" >lines 2>said.lines & one=$!
"$@" --json -c 8 >objects 2>said.objects & two=$!
"$@" 2>said.head | head -2 >head & three=$!
read go
kill -INT $one; wait $one; echo $?; wait $two; echo $?; wait $three; echo $?
"""


def test_packets_live_in_the_background_of_a_script(place: Place, server: Any) -> None:
    command = [HIL, "capture", "bus0", "--runtime-dir", str(place.runtime)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    script = subprocess.Popen(["sh", "-c", SCRIPT, "sh", *command], cwd=place.folder, **pipes)
    texts = {name: place.folder / name for name in ("lines", "objects", "head")}
    for name in texts:
        said = place.folder / f"said.{name}"
        until(
            lambda said=said: said.exists() and "Ctrl-C ends it" in said.read_text(), f"the capture of {name}"
        )
    talk(place)
    until(lambda: texts["lines"].read_text().endswith("bus0 1 -> all y\n"), "the last packet")
    assert script.communicate("go\n", PATIENCE_S)[0] == "0\n0\n0\n"
    lines = texts["lines"].read_text().splitlines()
    assert texts["head"].read_text().splitlines() == lines[:2]
    assert [json.loads(row)["text"] for row in texts["objects"].read_text().splitlines()] == [
        line.split(" bus0 ")[1] for line in lines
    ]
    said = (place.folder / "said.lines").read_text().splitlines()
    assert said[0] == "hil: capturing bus0 (sac, 38400 baud); Ctrl-C ends it"
    assert said[1] == "hil: 8 packets, 2 with errors; none lost"
    assert "Broken" not in (place.folder / "said.head").read_text()
