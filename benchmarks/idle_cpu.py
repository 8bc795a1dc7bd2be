"""CPU of a daemon with 32 idle ports, above an empty native loop at the same rate.

The empty loop is the core's own thread without a board: it wakes and sleeps."""

import json
import statistics
import subprocess
import sys
import time

from _processes import daemon, precise_cpu_s
from _report import is_quick, report

PORTS = 32
LIMIT_POINTS = 3.0
EMPTY = """
import time
from hil.core import Core
core = Core(1)
core.native.rt_start(1_000_000, 1.0, 80, {cpu})
print(flush=True)
time.sleep(600)
"""


def points(pid: int, seconds: float) -> float:
    """CPU use over a while, in hundredths of a core."""
    before, began = precise_cpu_s(pid), time.perf_counter()
    time.sleep(seconds)
    return 100 * (precise_cpu_s(pid) - before) / (time.perf_counter() - began)


def empty(seconds: float) -> float:
    import os

    cpu = max(os.sched_getaffinity(0))
    process = subprocess.Popen([sys.executable, "-c", EMPTY.format(cpu=cpu)], stdout=subprocess.PIPE)
    assert process.stdout
    process.stdout.readline()
    try:
        return points(process.pid, seconds)
    finally:
        process.kill()
        process.wait()


def main() -> None:
    """Medians of alternating runs."""
    devices = {f"m{i}": {"profile": "mechaduino"} for i in range(1, PORTS + 1)}
    config = json.dumps({"bench": "bench", "devices": devices})
    seconds, idle, bare = 3.0 if is_quick() else 8.0, [], []
    for _ in range(3 if is_quick() else 5):
        bare.append(empty(seconds))
        with daemon(config) as running:
            time.sleep(5)  # the boards' own start, with what they print
            idle.append(points(running.pid, seconds))
    value, reference = statistics.median(idle), statistics.median(bare)
    holds = value - reference <= LIMIT_POINTS
    extra = {
        "reference": "the core's thread with nothing to do, 1 kHz",
        "above_points": value - reference,
        "limit_points": LIMIT_POINTS,
        "holds": holds,
        "runs": {"daemon": idle, "empty": bare},
    }
    report("idle_cpu_32_ports", value, "% of a core", reference, None, extra)
    print(f"  above it: {value - reference:.2f} points (<= {LIMIT_POINTS:g}: {'yes' if holds else 'NO'})")


if __name__ == "__main__":
    main()
