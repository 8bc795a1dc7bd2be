"""Speed of the virtual clock: a minute of one Mechaduino in closed loop through the test kit.

The figure is wall time for a second of simulated time, in ms; the reference is what 1000 times real time
takes. The figure includes everything: the kit, the firmware's waiting, the control law, the motor.
"""

import statistics
import time

from _report import is_quick, report

from hil.testing import Bench

TIMES_REAL_TIME = 1000
PLANTS = ("simple", "full")


def closed_loop(plant: str) -> Bench:
    """A board that holds 90 degrees."""
    device = {"profile": "mechaduino", "port": "memory", "plant": plant, "flash": {"table": "identity"}}
    bench = Bench({"bench": "speed", "devices": {"m1": device}})
    bench.run_until(4500)
    for typed, for_ms in ((b"xy", 500), (b"r90\n", 1000)):
        bench.port("m1").write(typed)
        bench.run(for_ms)
    return bench


def wall_ms_per_s(bench: Bench, run_s: int) -> float:
    steps = bench.axis("m1").snapshot().control_steps
    began_ns = time.perf_counter_ns()
    bench.run(ms=run_s * 1000)
    took_ms = (time.perf_counter_ns() - began_ns) / 1e6
    made = bench.axis("m1").snapshot().control_steps - steps
    assert made >= run_s * 6499, f"{made} control steps in {run_s} s: the loop did not run"
    return took_ms / run_s


def main() -> None:
    run_s, rounds = (10, 1) if is_quick() else (60, 5)
    for plant in PLANTS:
        with closed_loop(plant) as bench:
            runs = [wall_ms_per_s(bench, run_s) for _ in range(rounds)]
        found = statistics.median(runs)
        limit = 1.0 if plant == "simple" else None
        report(
            f"virtual_speed_{plant}", found, "ms/s", 1000 / TIMES_REAL_TIME, limit,
            {"reference": f"{TIMES_REAL_TIME} times real time", "plant": plant, "seconds": run_s,
             "times_real_time": 1000 / found, "runs": runs},
        )  # fmt: skip


if __name__ == "__main__":
    main()
