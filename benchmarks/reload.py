"""Longest answer time of a board while a reload adds another to its bench of 200."""

import json
import os
import select
import statistics
import subprocess
import threading
import time

from _processes import HIL, daemon
from _report import is_quick, report

BOARDS = 200
LIMIT_S = 0.020


def config(extra: int) -> str:
    """Configuration of the bench. ``extra``: the board beside those that are always there; 0: none."""
    devices = {f"m{n}": {"profile": "mechaduino"} for n in range(BOARDS - 1)} | {"s1": {"profile": "sac"}}
    more = {f"x{extra}": {"profile": "mechaduino"}} if extra else {}
    return json.dumps({"bench": "bench", "devices": devices | more})


def longest_s(fd: int, is_over: threading.Event) -> float:
    """The longest round trip of a carriage return and its prompt, until it is over."""
    longest = 0.0
    while not is_over.is_set():
        began = time.perf_counter()
        os.write(fd, b"\r")
        got = b""
        while b"SAC>" not in got:
            if not select.select([fd], [], [], 10)[0]:
                raise TimeoutError("the board does not answer")
            got += os.read(fd, 4096)
        longest = max(longest, time.perf_counter() - began)
    return longest


def main() -> None:
    """Medians of reloads and, in turns, of the same time without one."""
    alone, beside, took = [], [], []
    with daemon(config(0)) as bench:
        runtime = bench.folder / "run"
        fd = os.open(bench.port("s1"), os.O_RDWR | os.O_NOCTTY)
        time.sleep(5)  # the boards' start
        for n in range(1, 4 if is_quick() else 16):
            over = threading.Event()
            command = [HIL, "reload", "--runtime-dir", str(runtime)]
            (bench.folder / "bench.yaml").write_text(config(n))
            longest: list[float] = []
            asking = threading.Thread(target=lambda o=over, x=longest: x.append(longest_s(fd, o)))
            began = time.perf_counter()
            asking.start()
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            took.append(time.perf_counter() - began)
            over.set()
            asking.join()
            beside += longest
            over = threading.Event()
            threading.Timer(took[-1], over.set).start()
            alone.append(longest_s(fd, over))
        os.close(fd)
    value, reference = statistics.median(beside), statistics.median(alone)
    late_s = value - reference
    extra = {
        "reference": "the same without a reload",
        "limit_s": LIMIT_S,
        "holds": late_s <= LIMIT_S,
        "beside_s": beside,
        "alone_s": alone,
        "took_s": took,
    }
    report("reload", value, "s", reference, None, extra)
    print(
        f"  longer by {late_s * 1000:.1f} ms, to be at most {LIMIT_S * 1000:g}:"
        f" {'yes' if late_s <= LIMIT_S else 'NO'}; a reload with its command takes"
        f" {statistics.median(took):.2f} s"
    )


if __name__ == "__main__":
    main()
