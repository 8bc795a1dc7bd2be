"""Many seeds: a test of 32 nodes with five faults and 10 simulated seconds, at 1000 seeds on two cores.

The figure is the CPU time of pytest and its two workers for 1000 seeds, with their start; the reference is
what two cores have in 60 s; --quick counts the start ten times. The master asks a node every 50 ms.
"""

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from _report import is_quick, report

SEEDS, CORES, WALL_S = 1000, 2, 60
TEST = """
from device_profiles.sac.packet import encode

FAULTS = {
    ("packet_nak", "s4.network"): 0.3,
    ("packet_no_ack", "s5.network"): 0.2,
    ("packet_bad_crc", "s6.network"): 0.1,
    ("wire_noise", "bus0"): 0.0001,
    ("byte_flip", "s7"): 0.001,
}


def test_nodes_answer(segment):
    b = segment(32)
    for (kind, target), rate in FAULTS.items():
        b.fault(kind, target, rate=rate)
    tap, begin_ns, node, answers = b.tap("bus0.master"), b.now_ns, 0, 0
    while b.now_ns < begin_ns + 10_000_000_000:
        tap.write(encode(4 + node, 1, b"y"))
        b.run(ms=50)
        answers += tap.read() != b""
        node = (node + 1) % 32
    assert 180 < answers <= 200
"""


def children_cpu_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    seeds = 100 if is_quick() else SEEDS
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "test_nodes.py").write_text(TEST)
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", str(CORES)]
        env = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])}
        began_s = children_cpu_s()
        done = subprocess.run(
            [*command, "--hil-seeds", str(seeds)], cwd=folder, env=env, capture_output=True, text=True
        )
        cpu_s = children_cpu_s() - began_s
    assert f"{seeds} passed" in done.stdout, done.stdout + done.stderr
    report(
        "many_seeds", cpu_s * SEEDS / seeds, "s", CORES * WALL_S, None if is_quick() else 1.0,
        {"reference": f"{CORES} cores for {WALL_S} s", "seeds": seeds, "ms_per_seed": cpu_s * 1000 / seeds},
    )  # fmt: skip


if __name__ == "__main__":
    main()
