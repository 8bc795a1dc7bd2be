"""Recordings of benches that run: always on, listed, and whole however the daemon ends."""

import gzip
import json
import os
import re
import subprocess
import threading
from pathlib import Path
from typing import Any

import pytest
from e2e_support import PATIENCE_S, Place, Server, config, until
from markdown_blocks import blocks

from hil.compose.log_lines import LogLines
from hil.compose.recordings_folder import recordings_in
from hil.sim.log_reading import KILLED, LogReading

pytestmark = pytest.mark.long


def recordings(place: Place, bench: str = "t") -> list[Path]:
    return recordings_in(place.state / bench / "recordings")


def listed(place: Place) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = json.loads(
        place.cli("recordings", "--state-dir", str(place.state), "--json")
    )
    return rows


def asked(server: Server, text: bytes = b"p") -> None:
    """Ask the board something, until the answer is in the recording."""
    with server.client("m1") as client:
        client.ask(text)


def test_every_run_is_recorded_and_listed(place: Place) -> None:
    server = place.serve(config(speed=20)).ready()
    asked(server)
    running = listed(place)
    server.ask("inject", fault="byte_flip", target="m1", parameters={"rate": 0.5})
    server.stop()
    (path,) = recordings(place)
    (row,) = listed(place)
    assert [each["end"] for each in (*running, row)] == ["running", "stopped"]
    assert (row["bench"], row["faults"], row["problem"]) == ("t", {"byte_flip": 1}, None)
    assert (row["path"], row["bytes"]) == (str(path), path.stat().st_size)
    with gzip.open(path) as file:
        lines = [json.loads(line) for line in file]
    assert row["inputs"] == sum("input" in line for line in lines) >= 2
    assert row["length_ns"] == lines[-1]["at_ns"] > 10**9
    assert lines[0]["begun"].endswith("Z")
    assert set(lines[0]) == {"format", "version", "program", "begun", "speed", "config", "nvm", "ports"}
    shown = place.cli("recordings", "--state-dir", str(place.state))
    assert re.search(rf"t/{path.name[:20]} .* stopped +1 byte_flip ", shown)
    assert place.cli("replay", str(path)).startswith("identical: ")


@pytest.mark.thorough
def test_no_log_records_nothing_and_log_records_elsewhere(place: Place) -> None:
    place.serve(config(), "--no-log").ready().stop()
    log = place.folder / "run.hil.gz"
    place.serve(config(), "--log", str(log)).ready().stop()
    assert not (place.state / "t" / "recordings").exists()
    assert place.cli("replay", str(log)).startswith("identical: ")
    assert gzip.decompress(log.read_bytes()).splitlines()[-1].startswith(b'{"end":true,"why":"stopped"')
    said = place.launch(config(), "--no-log", "--log", str(log)).refused()
    assert "--no-log records nothing, --log records in a file: give one" in said
    place.serve(config(recordings={"keep_runs": 0})).ready().stop()
    assert not (place.state / "t" / "recordings").exists()


def test_a_killed_bench_says_where_its_end_is(place: Place) -> None:
    server = place.serve(config()).ready()
    asked(server)
    (path,) = recordings(place)
    until(lambda: b'"input":"bytes"' in unpacked(path), "the input")
    server.kill()
    assert KILLED in place.cli("replay", str(path))
    server = place.serve(config()).ready()
    recording = server.ask("status")["recording"]
    show = f"hil replay {path} --until -5s --serve"
    assert recording["before"] == {"path": str(path), "end": "was killed", "show": show}
    assert recording["path"] == str(recordings(place)[-1])
    assert f"the run before was killed; to see its end: {show}" in server.output
    assert f"the run before was killed; to see its end: {show}" in place.cli("status")
    server.stop()
    assert [row["end"] for row in listed(place)] == ["killed", "stopped"]
    server = place.serve(config()).ready()
    assert server.ask("status")["recording"]["before"] is None
    server.stop()


def unpacked(path: Path) -> bytes:
    with LogLines(path) as lines:
        return b"".join(lines.more())


def test_a_recording_is_read_while_a_bench_writes_it(place: Place) -> None:
    server = place.serve(config()).ready()
    (path,) = recordings(place)
    reading = LogReading(str(path))
    with LogLines(path) as lines:

        def read_on() -> int:
            for line in lines.more():
                reading.add(line)
            return len(reading.log().inputs)

        for count in range(1, 4):
            asked(server)
            until(lambda count=count: read_on() >= count, f"input {count}")
        assert reading.log().cut == KILLED
        server.stop()
        read_on()
    assert (reading.log().cut, reading.log().why) == ("", "stopped")


def test_a_recording_that_cannot_be_made_is_said_and_nothing_else(place: Place) -> None:
    (place.state / "t").mkdir(parents=True, mode=0o700)
    (place.state / "t" / "recordings").write_text("a file of somebody's")
    server = place.serve(config()).ready()
    assert "this run is not recorded: " in server.output
    recording = server.ask("status")["recording"]
    assert recording["path"] is None
    assert "recordings: " in recording["problem"]
    assert "recording     none; " in place.cli("status")
    asked(server)
    server.stop()
    assert listed(place) == []


def test_a_full_disk_ends_the_recording_alone(place: Place) -> None:
    folder = place.state / "t" / "recordings"
    folder.mkdir(parents=True)
    for each in (place.state, place.state / "t", folder):
        each.chmod(0o700)
    mount = ["mount", "-t", "tmpfs", "-o", "size=128k,mode=0700", "tmpfs", str(folder)]
    if os.getuid() != 0 or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("mounting a tmpfs is not permitted here")
    try:
        server = place.serve(config(speed=5)).ready()
        (path,) = recordings(place)
        (folder / "filler").write_bytes(bytes(128 * 1024 - path.stat().st_size // 4096 * 4096 - 4096 * 3))
        with server.client("m1") as client:
            for _ in range(40):
                client.ask(b"p")
                if server.ask("status")["recording"]["problem"]:
                    break
                client.ask(b"sq")
        until(lambda: server.ask("status")["recording"]["problem"], "its end", PATIENCE_S)
        asked(server)
        said = server.stop()
        assert said.count("No space left on device; nothing more is written to it") == 1
        assert place.cli("replay", str(path)).startswith("identical: ")
        assert listed(place)[0]["end"] == "unwritable"
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def test_a_recording_that_used_its_room_ends_and_the_bench_goes_on(place: Place) -> None:
    folder = place.state / "t" / "recordings"
    folder.mkdir(parents=True)
    for each in (place.state, place.state / "t", folder):
        each.chmod(0o700)
    old = folder / "2020-01-01T00-00-00Z.hil.gz"
    old.write_bytes(bytes(900_000))
    server = place.serve(config(speed=100, recordings={"keep_MB": 1})).ready()
    assert old.exists()
    path = recordings(place)[-1]
    with server.client("m1") as client:
        for _ in range(400):
            client.write(b"q")
            client.read_until(b"\r\n")
            client.quiet(0.02)
            if server.ask("status")["recording"]["problem"]:
                break
    problem = server.ask("status")["recording"]["problem"]
    assert problem == "its room of 1 MB is used; the bench goes on without it"
    asked(server)
    assert server.stop().count("its room of 1 MB is used") == 1
    assert listed(place)[-1]["end"] == "full"
    assert path.stat().st_size < 1_600_000  # and what came within one look at it, on a machine that is busy
    assert "its room was used" in place.cli("replay", str(path))


@pytest.mark.thorough
def test_a_hung_bench_says_where_its_end_is(place: Place) -> None:
    place.hil("profile", "new", "hanger", "--folder", str(place.folder))
    program = place.folder / "hanger" / "firmware.py"
    hanger = """
class Hanger:
    def __init__(self, board):
        self.board = board

    def interrupt(self, event):
        pass

    def main(self):
        yield ByteAvailable()
        if self.board.uart.read() == ord("x"):
            sum(range(10**12))  # C code that looks at no signals
"""
    program.write_text(program.read_text().partition("class ")[0] + hanger)
    (place.folder / "hanger" / "board.py").write_text(
        "from hil.vocab.profile import Profile\n\nfrom .firmware import Hanger\n\n"
        "PROFILE = Profile(firmware=Hanger)\n"
    )
    bench = "bench: t\nprofile_path: [.]\ndevices: {h1: {profile: hanger}}\n"
    server = place.serve(bench).started()
    with server.client("h1") as client:
        client.write(b"x")
        server.refused(code=70)
    (path,) = recordings(place)
    assert [row["end"] for row in listed(place)] == ["killed"]  # until the next start has looked
    server = place.serve(bench).started()
    before = server.ask("status")["recording"]["before"]
    assert (before["path"], before["end"]) == (str(path), "ended in the firmware of h1, which hung")
    server.stop()
    assert [(row["end"], row["hung"]) for row in listed(place)] == [("hung", "h1"), ("stopped", None)]
    assert "hung: h1" in place.cli("recordings", "--state-dir", str(place.state))


def python_blocks() -> list[str]:
    return [each.text for each in blocks("docs/log-format.md") if each.language == "python"]


def test_the_pages_programs_read_a_recording(place: Place, capsys: pytest.CaptureFixture[str]) -> None:
    """The one that follows it does so to its end, over members of the file."""
    whole, follows = python_blocks()
    server = place.serve(config(speed=20)).ready()
    (path,) = recordings(place)
    names: dict[str, Any] = {}
    exec(follows, names)
    lines: list[dict[str, Any]] = []
    reader = threading.Thread(target=lambda: lines.extend(names["follow"](path)))
    reader.start()
    for _ in range(3):
        asked(server)
    until(lambda: any("input" in line for line in unpacked_lines(path)), "the input")
    with pytest.raises(EOFError):
        exec(whole.replace("run.hil.gz", str(path)), {})
    assert " m1 bytes\n" in capsys.readouterr().out
    server.stop()
    reader.join(PATIENCE_S)
    assert (lines[0]["format"], lines[-1]["why"]) == ("hil-inputs", "stopped")
    assert lines == unpacked_lines(path)
    exec(whole.replace("run.hil.gz", str(path)), {})
    assert capsys.readouterr().out.count(" m1 bytes\n") == sum("input" in line for line in lines) == 3


def unpacked_lines(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in unpacked(path).splitlines()]
