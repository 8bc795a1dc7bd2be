"""``hil sac``: a companion's files to a twin, and to a board that is only a serial port."""

import os
import re
import signal
import subprocess
import threading
import tty
from pathlib import Path
from typing import Any

import pytest
from e2e_support import HIL, PATIENCE_S, Place, config

SAC: dict[str, Any] = {"profile": "sac", "flash": {}}
ROW = " {} , {} , 1 , 1 , 69 , 4321 , 1 , 10.47 , .5 , 3 , 1 , 2400000 \r\n"
QUEUE = "".join(ROW.format(position, 100 + position) for position in range(1, 31))


@pytest.fixture
def queue(place: Place) -> Path:
    path = place.folder / "queue.txt"
    path.write_bytes(QUEUE.encode())
    return path


def sac(place: Place, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [HIL, "sac", *arguments, "--runtime-dir", str(place.runtime)]
    return subprocess.run(command, capture_output=True, text=True, timeout=3 * PATIENCE_S)


@pytest.mark.thorough
@pytest.mark.parametrize("port", ["pty", "tcp"])
def test_a_queue_goes_to_a_twin_and_comes_back(place: Place, queue: Path, port: str) -> None:
    server = place.serve(config(speed=5, devices={"s1": SAC | {"port": port}}))
    address = server.ask("list")["devices"][0]["address"]
    loaded = sac(place, "load", str(queue), "--store")
    assert loaded.stdout == "30 rows are in the board's queue and its EEPROM\n", loaded
    assert "row 30 of 30" in loaded.stderr
    back = place.folder / "back.txt"
    as_a_board = sac(place, "save", str(back), "--port", address)
    assert as_a_board.returncode == 0, as_a_board
    assert back.read_bytes() == queue.read_bytes()
    shots = place.folder / "shots.txt"
    shots.write_bytes(b"\r\nv159\r\n" + b"\r\n" * 98)
    sent = sac(place, "oneshot", str(shots), "2")
    assert sent.stdout == "sent: v159\n", sent
    refused = sac(place, "oneshot", str(shots), "1")
    assert (refused.returncode, refused.stderr.splitlines()[1]) == (
        2,
        f"{shots}:1:1: one-shot 1 is empty; filled are 2",
    )


def test_a_queue_is_saved_into_what_has_the_name(place: Place, queue: Path) -> None:
    place.serve(config(speed=20, devices={"s1": SAC}))
    assert sac(place, "load", str(queue)).returncode == 0
    full = sac(place, "save", "/dev/full")
    assert (full.returncode, full.stderr) == (2, "hil: /dev/full: No space left on device\n")
    assert Path("/dev/full").is_char_device()
    victim, link = place.folder / "victim", place.folder / "link.txt"
    victim.write_bytes(b"mine")
    (place.folder / "link.txt.part").symlink_to(victim)
    link.symlink_to("saved.txt")
    assert sac(place, "save", str(link)).returncode == 0
    assert (place.folder / "saved.txt").read_bytes() == queue.read_bytes()
    assert link.is_symlink()
    assert victim.read_bytes() == b"mine"


def test_a_bad_file_is_told_and_nothing_is_sent(place: Place, queue: Path) -> None:
    server = place.serve(config(speed=5, devices={"s1": SAC}))
    queue.write_bytes(QUEUE.replace(" 107 ", " x ").replace(" 9 ,", " 8 ,").encode())
    refused = sac(place, "load", str(queue))
    assert refused.returncode == 2
    assert [line for line in refused.stderr.splitlines() if line.startswith(str(queue))] == [
        f'{queue}:7:6: steps is "x"; write a whole number',
        f"{queue}:9:1: position 8 stands twice; a queue has each once",
    ]
    assert server.status("s1")["rx_bytes"] == 0


def test_another_reader_of_the_terminal_is_a_reason_to_refuse(place: Place, queue: Path) -> None:
    server = place.serve(config(speed=5, devices={"s1": SAC}))
    with server.client("s1"):
        refused = sac(place, "load", str(queue))
        assert refused.returncode == 1
        assert "another program has" in refused.stderr
    assert sac(place, "load", str(queue), "--device", "m1").returncode == 2
    assert sac(place, "load", str(queue), "--device", "s1", "--port", "/dev/null").returncode == 2
    missing = sac(place, "load", str(queue), "--port", "/dev/not-there")
    assert (missing.returncode, missing.stderr.count("\n")) == (1, 1)


def test_an_adapter_that_disappears_says_where_it_stopped(place: Place, queue: Path) -> None:
    """A board that is a thread behind a pseudo-terminal, which is closed at row 12."""
    master, slave = os.openpty()
    tty.setraw(slave)
    path = os.ttyname(slave)
    lines: list[bytes] = []

    def board() -> None:
        held = b""
        while True:
            held += os.read(master, 1000)
            while b"\r" in held:
                line, held = held.split(b"\r", 1)
                lines.append(line)
                if line.startswith(b"q12m"):
                    os.close(slave)
                    os.close(master)
                    return
                answer = {b"cc": b"a sprf\t\t200\r\n", b"vd": b"0\t0\r\n"}.get(line, b"")
                os.write(master, line + b"\r\n" + answer + b"SAC>")

    thread = threading.Thread(target=board)
    thread.start()
    stopped = sac(place, "load", str(queue), "--port", path, "--store")
    thread.join(PATIENCE_S)
    assert stopped.returncode == 1
    assert "stopped at row 12 of 30: " in stopped.stderr
    assert "load it again" in stopped.stderr
    assert "Traceback" not in stopped.stderr
    assert stopped.stdout == ""
    assert b"qs" not in lines


def test_ctrl_c_says_what_is_in_the_board(place: Place, queue: Path) -> None:
    place.serve(config(speed=1, devices={"s1": SAC}))
    command = [HIL, "sac", "load", str(queue), "--runtime-dir", str(place.runtime)]
    loading = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert loading.stderr
    assert loading.stderr.readline().startswith("row 3 of 30")
    loading.send_signal(signal.SIGINT)
    said = loading.communicate(timeout=PATIENCE_S)[1]
    assert loading.returncode == 130
    assert re.search(r"hil: stopped at row \d+ of 30: interrupted; .*load it again\n$", said), said


def long_file(place: Place, count: int) -> tuple[Path, int]:
    """A file longer than a queue, and the sum of its steps."""
    path, total, rows = place.folder / "long.txt", 0, []
    for number in range(count):
        steps, is_ccw = 1 + number % 7, number % 3 == 0
        total += -steps if is_ccw else steps
        rows.append(f" {number + 1} , {steps} , {is_ccw:d} , 1 , 300 , 1000 , 0 , 999 , 999 , 0 , 0 , 0 \r\n")
    path.write_bytes("".join(rows).encode())
    return path, total


@pytest.mark.parametrize("count", [90, pytest.param(10_560, marks=pytest.mark.thorough)])
def test_a_long_file_is_streamed_in_two_parts(place: Place, count: int) -> None:
    path, total = long_file(place, count)
    server = place.serve(config(speed=20, devices={"s1": SAC}))
    begun = [HIL, "sac", "stream", str(path), "--to", "60", "--runtime-dir", str(place.runtime)]
    with subprocess.Popen(begun, stderr=subprocess.PIPE, text=True) as streaming:
        assert streaming.stderr is not None
        streaming.stderr.readline()
        streaming.send_signal(signal.SIGINT)
        said = streaming.stderr.read()
    assert streaming.returncode == 130, said
    found = re.search(r"^hil: rows up to (\d+) have run; go on with --from (\d+)\n$", said, re.MULTILINE)
    assert found, said
    command = [HIL, "sac", "stream", str(path), "--from", found[2], "--runtime-dir", str(place.runtime)]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=20 * PATIENCE_S)
    assert ended.stdout == f"{path}: {count - int(found[1]):,} rows have run\n", ended
    assert server.status("s1")["snapshot"]["commanded_deg"] == pytest.approx(total * 1.8)
