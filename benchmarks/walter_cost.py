"""Cost of Walter's arm: seven axes led by MOVETO ten times a second.

The figures are CPU time of this process for a second of simulated time, in ms, with one arm and with 50; the
reference is what 300 times real time takes for each arm. Beside them stands the same of arms that are enabled
and do nothing. All is in it: the kit, firmware, UARTs, drive laws, pulses.
`python benchmarks/walter_cost.py [--quick]`.
"""

import math
import re
import time

from _report import check_work, is_quick, report

from device_profiles.walter.arm_parts import SERVO_MS
from hil.testing import Bench

WANTED_MS_PER_S = 1000 / 300
"""CPU time of an arm for a simulated second: 300 times real time."""
ARMS = 50
STREAM_MS = 100.0
JOG_OF_HAND = re.compile(rb"\xff\xff.\xfd\x06", re.DOTALL)
"""Begin of a packet that moves the hand's servo: header, length, servo, I_JOG."""


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
    """Lead all axes along sines, ten targets a second.

    The hand's servo has to hear of it in each round.
    """
    for n in range(1, count + 1):
        bench.port(f"w{n}.servo").read()
    heard = 0
    steps = round(seconds * 1000 / STREAM_MS)
    for step in range(steps):
        deg = 20 * math.sin(step * 0.2)
        line = b"MOVETO " + b" ".join([b"%.2f" % deg] * 6) + b" %.2f 100\r" % (30 + deg)
        for n in range(1, count + 1):
            bench.port(f"w{n}").write(line)
        bench.run(ms=STREAM_MS)
        for n in range(1, count + 1):
            for port in (f"w{n}", f"w{n}.logger"):
                bench.port(port).read()
            heard += len(JOG_OF_HAND.findall(bench.port(f"w{n}.servo").read()))
    check_work("packets that move a servo", heard, count * steps * STREAM_MS / SERVO_MS, 0.2)


def cpu_ms_per_s(count: int, seconds: float) -> tuple[float, float]:
    """CPU time of arms that stand, and of arms that move, for a second."""
    with arms(count) as idle:
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
            f"walter_{count}", moving_ms, "ms/s", count * WANTED_MS_PER_S, 1.0,
            {"reference": "300 times real time for each arm", "arms": count, "idle_ms_per_s": idle_ms,
             "times_real_time": 1000 * count / moving_ms},
        )  # fmt: skip
        print(f"  {idle_ms:.3g} ms/s of them if all stand")


if __name__ == "__main__":
    main()
