"""SIGKILL at random moments: a file is never torn, and nothing acknowledged is ever lost."""

import os
import random
import select
import signal
import subprocess
import sys
from pathlib import Path
from queue import Queue
from typing import TextIO

import pytest

from hil.firmware.nvm import Content, decode
from hil.live.store import NvmStore

pytestmark = pytest.mark.long

KILLS = int(os.environ.get("HIL_KILLS", "100"))
"""Number of kills; `make kills` does more."""
PROFILE = "mechaduino"


def content(counter: int) -> Content:
    """Content of 1 B to 1 MB, different for each counter in every place and in length."""
    size = random.Random(counter).choice([1, 4_000, 65_536, 1_000_000])
    return Content(PROFILE, counter, {"table": counter.to_bytes(8, "little") * (size // 8 + counter % 7)})


def write_for_ever(directory: Path) -> None:
    """Write commits, of which two are always under way, and print each durable counter."""
    store = NvmStore(directory)
    counter = store.look("m1", PROFILE).content.counter
    answers: Queue[int] = Queue()

    def start() -> None:
        nonlocal counter
        counter += 1
        mine = counter

        def done(ok: bool, reason: str) -> None:
            assert ok, reason
            os.write(sys.stdout.fileno(), f"{mine}\n".encode())  # in one piece, however it ends
            answers.put(mine)

        store.commit("m1", content(mine), done)

    start()
    while True:
        start()
        answers.get()


def fork_writers(directory: Path) -> None:
    """Fork a writer for each line of standard input, one after the other. Imports are done once."""
    for _ in sys.stdin:
        if not (child := os.fork()):
            print(os.getpid(), flush=True)
            write_for_ever(directory)
        _, status = os.waitpid(child, 0)
        print(f"ended {os.waitstatus_to_exitcode(status)}", flush=True)


def killed(said: TextIO, count: int, after_s: float) -> list[int]:
    """Kill the writer that has begun, some time after it has acknowledged ``count`` commits; answers the
    counters of all that it has acknowledged."""
    writer, *acknowledged = [int(said.readline()) for _ in range(1 + count)]
    # The moment of the kill is the point here, and it has to be anywhere in a commit.
    select.select([], [], [], after_s)
    os.kill(writer, signal.SIGKILL)
    while not (line := said.readline()).startswith("ended "):
        acknowledged.append(int(line))
    assert line == f"ended {-signal.SIGKILL}\n"
    return acknowledged


def test_no_kill_tears_a_file_or_loses_an_acknowledged_commit(tmp_path: Path) -> None:
    moments = random.Random(20_240)
    command = [sys.executable, __file__, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as forker:
        assert forker.stdin
        assert forker.stdout
        for _ in range(KILLS):
            forker.stdin.write("\n")
            forker.stdin.flush()
            acknowledged = killed(forker.stdout, moments.randint(1, 4), moments.uniform(0.0, 0.02))
            stored = decode((tmp_path / "m1.nvm").read_bytes()).content
            assert stored == content(stored.counter)
            assert acknowledged[-1] <= stored.counter <= acknowledged[-1] + 2
            leftovers = {path.name for path in tmp_path.iterdir()}
            assert leftovers <= {"m1.nvm", "m1.nvm.new", "m1.nvm.old"}


if __name__ == "__main__":
    fork_writers(Path(sys.argv[1]))
