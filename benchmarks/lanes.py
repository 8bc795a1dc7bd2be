"""Axes that move together, beside the same axes each alone: CPU time, in turns, medians.

``lanes_bench_N_*``: N Mechaduinos that hold, in the kit, ms of CPU time for a simulated second of one; the
reference is the same with ``HIL_LANES=none``. ``lanes_replay_N_*``: the same for the replay of a log of 90
seconds of them, each of which is told a new angle every five seconds, compared whole. ``lanes_speed_N``: the
daemon with ``speed: 10``. ``lanes_group_*``: an axis of a CAN bus of 126 drives in closed loop, in the core,
beside one of 126 with groups of their own; for SACs of a line in motion, too, that report and that do not.
``lanes_bus_*``: the real-time thread's share of a core for 126 drives that hold on an idle bus.
``lanes_width_*``: a control step of the full plant with each width that this processor has, beside
``reference_axis.c``.

Needs a C compiler, as the installation from source does.
"""

import io
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from _processes import daemon, precise_cpu_s
from _report import is_quick, report
from axis_cost import build, reference_ns, run
from stepper_cost import reach

from hil.compose import find_catalogue, start_memories
from hil.compose.replay import MemoryOptions, replay
from hil.config import from_dict
from hil.core import Core
from hil.core.abi import Lanes
from hil.sim.bench import VIRTUAL, BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.testing import Bench
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.motion import CONTINUOUS_SLOT, MotionEntry, MotionSetup

PLANTS = ("simple", "full")
LIMITS = {100: 1 / 3.0, 8: 1 / 1.6}
ROUNDS = 1 if is_quick() else 5
SECONDS = 2 if is_quick() else 10
LOG_SECONDS, LOG_ROUNDS = (20, 1) if is_quick() else (90, 3)
GROUP = 126
GROUP_LIMIT, BUS_LIMIT, WIDTH_LIMIT = 1.1, 0.10, 0.40
WIDTHS = [each.name for each in Lanes if each <= Core(1).native.lanes]


def config(boards: int, plant: str, **more: object) -> dict[str, Any]:
    device = {"profile": "mechaduino", "plant": plant, "flash": {"table": "identity"}}
    return {"bench": "bench", "devices": {f"m{at}": device for at in range(boards)}, **more}


def holding(boards: int, plant: str, around: BenchHooks = VIRTUAL) -> Bench:
    """Boards that hold 90 degrees."""
    bench = Bench(config(boards, plant), around=around)
    bench.run_until(4500)
    for typed, for_ms in ((b"xy", 500), (b"r90\n", 1000)):
        for at in range(boards):
            bench.port(f"m{at}").write(typed)
        bench.run(for_ms)
    return bench


def cpu_s(work: Callable[[], object]) -> float:
    began_s = time.process_time()
    work()
    return time.process_time() - began_s


def in_turns(work: Callable[[], float], rounds: int) -> tuple[list[float], list[float]]:
    """Results with the widest lanes and without any, of runs in turns."""
    found: dict[str, list[float]] = {WIDTHS[-1]: [], Lanes.none.name: []}
    for turn in range(rounds):
        for lanes in [*found] if turn % 2 else reversed([*found]):
            os.environ["HIL_LANES"] = lanes
            found[lanes].append(work())
    del os.environ["HIL_LANES"]
    return found[WIDTHS[-1]], found[Lanes.none.name]


def compare(name: str, work: Callable[[], float], limit: float, rounds: int = ROUNDS) -> None:
    together, alone = in_turns(work, rounds)
    extra = {"reference": "each axis alone", "lanes": WIDTHS[-1], "runs": together, "reference_runs": alone}
    report(name, statistics.median(together), "ms/s", statistics.median(alone), limit, extra)


def bench_ms(boards: int, plant: str) -> float:
    with holding(boards, plant) as bench:
        spent_s = cpu_s(lambda: bench.run(SECONDS * 1000))
    return spent_s * 1000 / SECONDS / boards


def log_of(boards: int, plant: str) -> list[str]:
    """Log of boards that are told a new angle every five seconds, each at a time of its own."""
    text, catalogue, given = io.StringIO(), find_catalogue({"memory": MemoryOptions}), config(boards, plant)
    memories = start_memories(from_dict(given, catalogue), catalogue)
    around = BenchHooks(log=InputLogWriter(text, "benchmark", given, memories))
    with holding(boards, plant, around) as bench:
        for turn in range(LOG_SECONDS // 5):
            for at in range(boards):
                bench.run(5000 / boards)
                bench.port(f"m{at}").write(b"r%d\n" % (turn % 4 * 45))
    return text.getvalue().splitlines(keepends=True)


def replay_ms(lines: list[str], boards: int) -> float:
    began_s = time.process_time()
    assert replay(lines).difference() is None
    return (time.process_time() - began_s) * 1000 / (LOG_SECONDS + 6) / boards


def speed_share(boards: int, lanes: str) -> float:
    """Share of a core that a daemon takes for boards at ten times real time."""
    os.environ["HIL_LANES"] = lanes
    with daemon(json.dumps(config(boards, "simple", speed=10))) as running:
        for at in range(boards):
            with open(running.port(f"m{at}"), "wb", buffering=0) as port:
                port.write(b"xy")
        time.sleep(1.5)
        before_s, began_s = precise_cpu_s(running.pid), time.monotonic()
        time.sleep(SECONDS / 4)
        share = (precise_cpu_s(running.pid) - before_s) / (time.monotonic() - began_s)
    del os.environ["HIL_LANES"]
    return share


def sac_ns(together: int, *, reports: bool) -> float:
    """CPU time for a pulse of 126 SACs in motion, so many a group."""
    profile = find_catalogue().profiles["sac"]
    parameters = {name: parameter.default("simple") for name, parameter in profile.axis.items()}
    core, groups, axes = Core(GROUP), list[int](), list[Any]()
    for at in range(GROUP):
        if at % together == 0:
            groups.append(core.native.group_open(0))
        axis: Any = core.open_axis(groups[-1], AxisPlan(parameters, "simple", law=profile.law))
        axis.setup(MotionSetup(200, 10, 4, 1, 8, 0, True, 1_000_000, False, 36, 7))
        axis.write_entry(CONTINUOUS_SLOT, MotionEntry(0, False, 300, 1000, 100, 0, False, 0, False, 0, False))
        axis.report(reports)
        axis.run_continuous()
        axes.append(axis)
    now_ns = 3_000_000_000
    for group in groups:
        reach(core, group, now_ns)
    before = sum(axis.get("pulses") for axis in axes)
    began_s = time.process_time()
    for _ in range(300):
        now_ns += 1_000_000
        for group in groups:
            reach(core, group, now_ns)
    return (time.process_time() - began_s) * 1e9 / (sum(axis.get("pulses") for axis in axes) - before)


def medians(kinds: Mapping[str, Callable[[], float]]) -> dict[str, tuple[float, list[float]]]:
    """Medians and runs of works in turns."""
    found: dict[str, list[float]] = {name: [] for name in kinds}
    for turn in range(ROUNDS):
        for name in [*kinds] if turn % 2 else reversed([*kinds]):
            found[name].append(kinds[name]())
    return {name: (statistics.median(runs), runs) for name, runs in found.items()}


def beside(name: str, kinds: dict[str, Callable[[], float]], limit: float, reference: str) -> None:
    (of, runs), (other, others) = medians(kinds).values()
    extra = {"reference": reference, "runs": runs, "reference_runs": others}
    report(name, of, "ns", other, limit, extra)


def groups(core: str) -> None:
    ticks = 1300 if is_quick() else 2600

    def drive_ns(plant: str, together: int) -> float:
        return float(run(core, GROUP, ticks, plant, "virtual", together).split()[0])

    for plant in PLANTS:
        of: dict[str, Callable[[], float]] = {
            "together": lambda plant=plant: drive_ns(plant, GROUP),  # type: ignore[misc]
            "alone": lambda plant=plant: drive_ns(plant, 1),  # type: ignore[misc]
        }
        beside(f"lanes_group_{GROUP}_{plant}", of, GROUP_LIMIT, f"{GROUP} axes, each in its group")
    for reports, word in ((False, "sac"), (True, "sac_reports")):
        kinds: dict[str, Callable[[], float]] = {
            "together": lambda reports=reports: sac_ns(GROUP, reports=reports),  # type: ignore[misc]
            "alone": lambda reports=reports: sac_ns(1, reports=reports),  # type: ignore[misc]
        }
        beside(f"lanes_group_{GROUP}_{word}", kinds, GROUP_LIMIT, f"{GROUP} SACs, each in its group")
    for plant in PLANTS:
        runs = [float(run(core, GROUP, 2, plant, "rt", GROUP).split()[0]) for _ in range(ROUNDS)]
        extra = {"reference": "one core", "runs": runs}
        report(f"lanes_bus_{GROUP}_{plant}", statistics.median(runs), "core", 1.0, BUS_LIMIT, extra)


def widths(core: str, reference: str) -> None:
    ticks = 3250 if is_quick() else 6500

    def step_ns(lanes: str) -> float:
        told = subprocess.run(
            [core, "100", str(ticks), "full", "virtual", "1", lanes], check=True, stdout=subprocess.PIPE
        )
        return float(told.stdout.split()[0])

    kinds: dict[str, Callable[[], float]] = {"reference": lambda: reference_ns(reference, 100, ticks)}
    for lanes in WIDTHS:
        kinds[lanes] = lambda lanes=lanes: step_ns(lanes)  # type: ignore[misc]
    found = medians(kinds)
    plain, _ = found.pop("reference")
    for lanes, (value, runs) in found.items():
        limit = WIDTH_LIMIT if lanes == Lanes.avx512.name else None
        report(
            f"lanes_width_{lanes}", value, "ns", plain, limit, {"reference": "reference_axis.c", "runs": runs}
        )


def main() -> None:
    for boards, limit in LIMITS.items():
        for plant in PLANTS:
            compare(f"lanes_bench_{boards}_{plant}", lambda: bench_ms(boards, plant), limit)  # noqa: B023
            lines = log_of(boards, plant)
            compare(f"lanes_replay_{boards}_{plant}", lambda: replay_ms(lines, boards), limit, LOG_ROUNDS)  # noqa: B023
    shares = medians({lanes: lambda lanes=lanes: speed_share(8, lanes) for lanes in (WIDTHS[-1], "none")})  # type: ignore[misc]
    (value, runs), (alone, others) = shares.values()
    extra = {"reference": "each axis alone", "runs": runs, "reference_runs": others}
    report("lanes_speed_8", value, "core", alone, LIMITS[8], extra)
    with tempfile.TemporaryDirectory() as folder:
        core, reference = build(Path(folder))
        groups(core)
        widths(core, reference)


if __name__ == "__main__":
    sys.exit(main())
