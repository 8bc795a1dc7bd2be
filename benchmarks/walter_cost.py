"""Cost of Walter's arm: seven axes led by MOVETO ten times a second, against an arm that stands.

The figures are CPU time of this process for a second of simulated time, in ms, with one arm and with 50;
the reference is an arm that is ready and does nothing. All is in it: the kit, firmware, UARTs, drive laws,
pulses.
`python benchmarks/walter_cost.py [--quick]`.
"""

import math
import time

from _report import is_quick, report

from hil.testing import Bench

MOST_MS_PER_S = 1000 / 300
"""300 times real time."""
ARMS = 50
STREAM_MS = 100.0


def arms(count: int) -> Bench:
    """Arms that are ready, with power, and enabled."""
    bench = Bench({"bench": "cost", "devices": {f"w{n}": {"profile": "walter"} for n in range(1, count + 1)}})
    bench.run(ms=1000)
    for line in (b"POWER on\r", b"ENABLE\r"):
        for n in range(1, count + 1):
            bench.port(f"w{n}").write(line)
        bench.run(ms=200)
    return bench


def move(bench: Bench, count: int, seconds: float) -> None:
    """Lead all axes along sines, ten targets a second."""
    for step in range(round(seconds * 1000 / STREAM_MS)):
        deg = 20 * math.sin(step * 0.2)
        line = b"MOVETO " + b" ".join([b"%.2f" % deg] * 6) + b" %.2f 100\r" % (30 + deg)
        for n in range(1, count + 1):
            bench.port(f"w{n}").write(line)
        bench.run(ms=STREAM_MS)
        for n in range(1, count + 1):
            for port in (f"w{n}", f"w{n}.logger", f"w{n}.servo"):
                bench.port(port).read()


def cpu_ms_per_s(count: int, seconds: float) -> tuple[float, float]:
    """CPU time of arms that stand, and of arms that move, for a second."""
    with Bench(
        {"bench": "idle", "devices": {f"w{n}": {"profile": "walter"} for n in range(1, count + 1)}}
    ) as idle:
        idle.run(ms=1000)
        began = time.process_time()
        idle.run(ms=seconds * 1000)
        idle_ms = (time.process_time() - began) * 1000 / seconds
    with arms(count) as bench:
        move(bench, count, 1.0)
        began = time.process_time()
        move(bench, count, seconds)
        return idle_ms, (time.process_time() - began) * 1000 / seconds


def main() -> None:
    seconds = 3.0 if is_quick() else 30.0
    for count in (1, ARMS):
        idle_ms, moving_ms = cpu_ms_per_s(count, seconds if count == 1 else max(1.0, seconds / 10))
        report(
            f"walter_{count}", moving_ms, "ms/s", idle_ms, MOST_MS_PER_S if count == 1 else None,
            {"reference": "arms that do nothing", "arms": count, "times_real_time": 1000 / moving_ms,
             "percent_of_a_core_above_idle": (moving_ms - idle_ms) / 10},
        )  # fmt: skip


if __name__ == "__main__":
    main()
