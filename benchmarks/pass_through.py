"""Delay that a daemon adds to a round trip with a real board, here an echo behind a pseudo-terminal.

Side by side, turn by turn: a client on the board's own pseudo-terminal, and one on the daemon's. Prints both
medians and 99th percentiles, and the difference of the percentiles; at most 2 ms are wanted.
"""

import os
import select
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import tty
from pathlib import Path

ROUNDS = 300 if "--quick" in sys.argv else 3000
TURN = 50


def echo(master: int) -> None:
    while True:
        try:
            os.write(master, os.read(master, 4096))
        except OSError:
            return


def board() -> tuple[int, str]:
    master, slave = os.openpty()
    tty.setraw(slave)
    path = os.ttyname(slave)
    threading.Thread(target=echo, args=(master,), daemon=True).start()
    return slave, path


def round_trip_s(fd: int) -> float:
    start = time.perf_counter()
    os.write(fd, b"p")
    if not select.select([fd], [], [], 5)[0]:
        raise SystemExit("no answer within 5 s")
    os.read(fd, 100)
    return time.perf_counter() - start


def p99(values: list[float]) -> float:
    return sorted(values)[int(len(values) * 0.99)]


def main() -> None:
    (direct, _), (_, behind) = board(), board()
    with tempfile.TemporaryDirectory(prefix="hil-") as folder:
        bench = Path(folder, "b.yaml")
        bench.write_text(f"bench: b\ndevices:\n  s2: {{profile: sac, at: {behind}}}\n")
        hil = Path(sys.executable).with_name("hil")
        where = ["--runtime-dir", folder, "--state-dir", folder]
        daemon = subprocess.Popen([hil, "serve", bench, *where], stdout=subprocess.PIPE)
        assert daemon.stdout
        while b"Ctrl-C" not in daemon.stdout.readline():
            pass
        through = os.open(f"{folder}/b/s2", os.O_RDWR | os.O_NOCTTY)
        tty.setraw(through)
        times: dict[int, list[float]] = {direct: [], through: []}
        for _ in range(ROUNDS // TURN):
            for fd, kept in times.items():
                kept += [round_trip_s(fd) for _ in range(TURN)]
        os.close(through)
        daemon.terminate()
        daemon.wait()
    for name, kept in (("direct", times[direct]), ("through hil", times[through])):
        print(f"{name:12} median {statistics.median(kept) * 1e3:.3f} ms  p99 {p99(kept) * 1e3:.3f} ms")
    print(f"added        p99 {(p99(times[through]) - p99(times[direct])) * 1e3:.3f} ms, wanted at most 2 ms")


main()
