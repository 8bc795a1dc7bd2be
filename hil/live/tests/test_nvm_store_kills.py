"""SIGKILL at random moments: a file is never torn, and nothing acknowledged is ever lost."""

import os
import random
import signal
import subprocess
import sys
from pathlib import Path
from queue import Queue

from hil.firmware.nvm import Content, decode
from hil.live.store import NvmStore

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
            print(mine, flush=True)
            answers.put(mine)

        store.commit("m1", content(mine), done)

    start()
    while True:
        start()
        answers.get()


def test_no_kill_tears_a_file_or_loses_an_acknowledged_commit(tmp_path: Path) -> None:
    moments = random.Random(20_240)
    for _ in range(KILLS):
        writer = subprocess.Popen(
            [sys.executable, __file__, str(tmp_path)], stdout=subprocess.PIPE, text=True
        )
        assert writer.stdout is not None
        acknowledged = [int(writer.stdout.readline()) for _ in range(moments.randint(1, 4))]
        try:
            # The moment of the kill is the point here, and it has to be anywhere in a commit.
            writer.wait(timeout=moments.uniform(0.0, 0.02))
        except subprocess.TimeoutExpired:
            writer.kill()
        acknowledged += [int(line) for line in writer.stdout.read().split("\n") if line]
        assert writer.wait() == -signal.SIGKILL
        writer.stdout.close()

        stored = decode((tmp_path / "m1.nvm").read_bytes()).content
        assert stored == content(stored.counter)
        assert acknowledged[-1] <= stored.counter <= acknowledged[-1] + 2
        leftovers = {path.name for path in tmp_path.iterdir()}
        assert leftovers <= {"m1.nvm", "m1.nvm.new", "m1.nvm.old"}


if __name__ == "__main__":
    write_for_ever(Path(sys.argv[1]))
