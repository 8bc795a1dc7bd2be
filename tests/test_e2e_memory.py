"""Memories of the boards over restarts, kills, damaged files and full disks."""

import os
import random
import shutil
import signal
import stat
import struct
import subprocess
import zlib
from collections.abc import Iterator
from pathlib import Path

import pytest
from e2e_support import AS_STRANGER, Q_BYTES, STRANGER_UID, Client, Place, Server, config, needs_stranger

from hil.firmware.nvm import MAGIC, decode
from hil.testing import Bench

KILLS = int(os.environ.get("HIL_KILLS", "20"))
"""Kills around a flash write; more for a long run."""
WARNING = b"WARNING: Lookup table is empty!"
SPEED = 100
START_DEG = (6.3, 85.5)
"""Two shaft angles at power-up, whose calibrations make two different tables."""


def stored(start_deg: float = START_DEG[0], table: str = "stored") -> str:
    return config(speed=SPEED, devices={"m1": {"flash": {"table": table}, "axis": {"start_deg": start_deg}}})


def calibrate(client: Client) -> None:
    client.ask(b"c", b"non-volatile Flash memory!\r\n \r\n \r\n")


def query(client: Client) -> bytes:
    client.write(b"q")
    return client.read_until(b"\r\n};\r\n")


def booted(server: Server) -> tuple[Client, bytes]:
    """Connect a client, and ask for q. Whether the board warned is seen in the counters."""
    client = server.ready().client()
    return client, query(client)


def warned(server: Server) -> bool:
    """True if the board said more at boot than its banner, while nobody listened."""
    return bool(server.status()["unheard_bytes"] > 660)


@pytest.fixture(scope="module")
def answers() -> list[bytes]:
    """Answers to q after a calibration from each of START_DEG, and with an empty table: on the virtual
    clock."""
    found = []
    for start_deg in START_DEG:
        device = {"profile": "mechaduino", "port": "memory", "axis": {"start_deg": start_deg}}
        bench = Bench({"bench": "t", "devices": {"m1": device}})
        bench.run(ms=5000)
        bench.port("m1").write(b"c")
        bench.run(ms=40_000)
        bench.port("m1").read()
        bench.port("m1").write(b"q")
        found.append(bench.port("m1").read())
    assert found[0] != found[1]
    return found


@pytest.mark.thorough
def test_a_calibration_survives_a_restart(place: Place, answers: list[bytes]) -> None:
    server = place.serve(stored()).ready()
    with server.client() as client:
        server.ask("reset", device="m1")  # its boot text once, to somebody who listens, on a busy machine too
        assert WARNING in client.read_until(b"Run calibration\r\n")
        calibrate(client)
        calibrated = query(client)
    assert calibrated == answers[0]
    server.stop()
    for end in ("stop", "kill"):
        again = place.serve(stored()).ready()
        with again.client() as client:
            again.ask("reset", device="m1")
            client.read_until(b"encoder...\r\n")
            assert query(client) == b"" + calibrated  # no warning in between
        if end == "stop":
            again.stop()
        else:
            again.kill()
    # A table from the configuration does not touch what is stored.
    for table in ("identity", "empty"):
        other = place.serve(stored(table=table))
        client, answer = booted(other)
        client.close()
        assert answer != calibrated
        assert len(answer) == Q_BYTES or table == "empty"
        other.stop()
    client, answer = booted(place.serve(stored()))
    assert answer == calibrated
    client.close()


def last_dot(client: Client) -> None:
    """Wait for the end of the steps: what follows is the write."""
    client.write(b"c")
    client.read_until(b"\r\n90% ...................")


@pytest.mark.thorough
def test_kills_around_the_flash_write(place: Place, answers: list[bytes]) -> None:
    """The next start finds the old table or the new one, entirely, whatever was going on; the new one if the
    board had said that it was written."""
    chance = random.Random(KILLS)
    server = place.serve(stored(START_DEG[0]))
    with server.ready().client() as client:
        calibrate(client)
    server.kill()
    possible = [answers[0]]
    found_new = 0
    for attempt in range(1, KILLS + 1):
        start_deg, new = START_DEG[attempt % 2], answers[attempt % 2]
        server = place.serve(stored(start_deg))
        client, answer = booted(server)
        with client:
            assert answer in possible
            found_new += attempt > 1 and answer == possible[-1]
            last_dot(client)
            shown = client.quiet(chance.uniform(0, 0.012))
            server.kill()
        said = b"has been written to non-volatile" in shown
        possible = [new] if said else [answer, new]
    client, answer = booted(place.serve(stored()))
    with client:
        assert answer in possible
    print(f"{KILLS} kills; {found_new} times the new table was found")
    leftovers = [path.name for path in (place.state / "t").iterdir() if path.name.endswith(".damaged-1")]
    assert leftovers == []


@pytest.mark.thorough
def test_a_stop_in_the_middle_of_the_flash_write(place: Place, answers: list[bytes]) -> None:
    """SIGTERM waits for the write, and its answer is in the log."""
    chance = random.Random(2)
    for attempt in range(4):
        log = place.folder / f"log{attempt}"
        server = place.serve(stored(START_DEG[attempt % 2]), "--log", str(log)).ready()
        with server.client() as client:
            last_dot(client)
            client.quiet(chance.uniform(0, 0.008))
            server.stop()
        assert "identical" in place.cli("replay", str(log))
        assert [path.name for path in (place.state / "t").iterdir()] in (["m1.nvm"], [])


@pytest.mark.thorough
def test_a_damaged_file_is_kept_aside(place: Place) -> None:
    folder = place.state / "t"
    server = place.serve(stored())
    with server.ready().client() as client:
        calibrate(client)
    server.stop()
    whole = (folder / "m1.nvm").read_bytes()
    wrong = {
        "the checksum is wrong": whole[:5000] + bytes([whole[5000] ^ 1]) + whole[5001:],
        "damaged: too short": whole[:12],
        "not a memory file": b"precious",
    }
    for number, (reason, data) in enumerate(wrong.items(), start=1):
        (folder / "m1.nvm").write_bytes(data)
        server = place.serve(stored()).ready()
        note = f"m1.nvm: {reason}" if reason.startswith(("not", "format", "damaged")) else reason
        for said in (server.output, server.status()["note"], place.cli("status")):
            assert note in said
            assert f"m1.nvm.damaged-{number}" in said
        assert (folder / f"m1.nvm.damaged-{number}").read_bytes() == data
        assert warned(server)
        server.stop()
    assert not (folder / "m1.nvm").exists()


def test_a_newer_file_is_left_for_the_newer_program(place: Place) -> None:
    folder = place.state / "t"
    folder.mkdir(parents=True)
    newer = with_checksum(MAGIC + struct.pack("<H", 99), b"new")
    (folder / "m1.nvm").write_bytes(newer)
    said = place.launch(stored()).refused()
    assert (
        f"{folder}/m1.nvm: format version 99 is unknown: this program reads 1 to 2; start the newer" in said
    )
    assert [(path.name, path.read_bytes()) for path in folder.iterdir()] == [("m1.nvm", newer)]


def with_checksum(head: bytes, body: bytes) -> bytes:
    return head + struct.pack("<I", zlib.crc32(body, zlib.crc32(head))) + body


@pytest.mark.thorough
def test_a_file_of_version_1_is_migrated(place: Place, answers: list[bytes]) -> None:
    folder = place.state / "t"
    server = place.serve(stored())
    with server.ready().client() as client:
        calibrate(client)
    server.stop()
    table = decode((folder / "m1.nvm").read_bytes()).content.sections["lookup"]
    old = with_checksum(MAGIC + struct.pack("<H", 1), table)
    (folder / "m1.nvm").write_bytes(old)
    server = place.serve(stored(START_DEG[1]))
    client, answer = booted(server)
    with client:
        assert answer == answers[0]
        assert "version 1 was migrated to 2" in server.output
        assert "version 1 was migrated to 2" in server.status()["note"]
        assert (folder / "m1.nvm").read_bytes() == old  # until something is written
        calibrate(client)
    server.stop()
    server = place.serve(stored())
    client, answer = booted(server)
    with client:
        assert answer == answers[1]
        assert server.status()["note"] is None
    assert set(decode((folder / "m1.nvm").read_bytes()).content.sections) == {"lookup"}


def test_a_file_that_cannot_be_read_is_not_overwritten(place: Place) -> None:
    (place.state / "t" / "m1.nvm").mkdir(parents=True)
    said = place.launch(stored()).refused()
    assert f"{place.state}/t/m1.nvm cannot be read: Is a directory" in said


@needs_stranger
def test_a_state_directory_that_becomes_read_only(place: Place, answers: list[bytes]) -> None:
    for folder in (place.runtime, place.state):
        folder.mkdir(mode=0o700)
        os.chown(folder, STRANGER_UID, STRANGER_UID)
    server = place.serve(stored(), prefix=AS_STRANGER).ready()
    with server.client() as client:
        calibrate(client)
        os.chown(place.state / "t", 0, 0)
        (place.state / "t").chmod(0o755)
        refuse_a_write(server, client, answers[0], "Permission denied")


@pytest.fixture
def tiny_disk(place: Place) -> Iterator[Path]:
    """The state directory on a file system that has room for one table, not for two."""
    place.state.mkdir(mode=0o700)
    mount = ["mount", "-t", "tmpfs", "-o", "size=100k,mode=0700", "tmpfs", str(place.state)]
    if os.getuid() != 0 or not shutil.which("mount") or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("mounting a tmpfs is not permitted here")
    try:
        yield place.state
    finally:
        subprocess.run(["umount", "-l", str(place.state)], check=True)


def test_a_full_disk_during_a_calibration(place: Place, tiny_disk: Path, answers: list[bytes]) -> None:
    server = place.serve(stored(), "--log", str(place.folder / "log")).ready()
    with server.client() as client:
        calibrate(client)
        refuse_a_write(server, client, answers[0], "No space left on device")
        assert [path.name for path in (tiny_disk / "t").iterdir()] == ["m1.nvm"]

        subprocess.run(["mount", "-o", "remount,size=1m", str(tiny_disk)], check=True)
        calibrate(client)
        assert server.status()["flash"] == "ok"
        assert query(client) != answers[0]
    server.stop()
    assert "identical" in place.cli("replay", str(place.folder / "log"))


def test_a_full_disk_under_the_log(place: Place, tiny_disk: Path) -> None:
    """The log ends, and says so; board and daemon go on, and what was logged can be replayed."""
    log = tiny_disk / "log"
    server = place.serve(config(speed=SPEED), "--log", str(log)).ready()
    with server.client() as client:
        for _ in range(3):
            query(client)
        assert client.ask(b"p").startswith(b"stepNumber: 0 ")
    said = server.stop()
    assert said.count(f"log {log}: No space left on device; nothing more is written to it") == 1
    said = place.cli("replay", str(log))
    assert said.startswith("identical: ")
    assert "up to where the log ends" in said


def refuse_a_write(server: Server, client: Client, table: bytes, reason: str) -> None:
    """Check that a calibration that would make another table fails, and changes nothing."""
    client.write(b"s" * 20)
    for _ in range(20):
        client.read_until(b"raw encoder: ")
    server.ask("reset", device="m1")  # the shaft is elsewhere when the calibration begins
    client.read_until(b"encoder...\r\n")
    calibrate(client)
    assert query(client) == table
    for said in (server.status()["flash"], server.output):
        assert f"m1.nvm was not written: {reason}" in said
    assert "it keeps its old content" in server.output
    assert server.process.poll() is None


def test_memories_are_private(place: Place) -> None:
    old = os.umask(0)
    try:
        server = place.serve(stored()).ready()
    finally:
        os.umask(old)
    with server.client() as client:
        calibrate(client)
    server.stop(signal.SIGINT)
    for path in (place.state, place.state / "t", place.state / "t" / "m1.nvm"):
        assert stat.S_IMODE(path.stat().st_mode) & 0o077 == 0
