"""Time from `hil serve` to a port that takes bytes, the board's own four seconds come after; the CPU time of
a start; and what `hil status` and `hil check` take."""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from _processes import HIL, cpu_s, daemon
from _report import is_quick, report

CONFIG = "bench: bench\ndevices: {m1: {profile: mechaduino}}\n"
LIMIT_S = 1.0
CPU_LIMIT_S = 0.7
"""CPU time of a bench from its start until it serves."""
WITH_BRIDGES = CONFIG + "bridges: {metrics: {}, modbus: {}, zenoh: {}}\n"
GOALS = {"status": 1.2, "check": 2.2, "check_bridges": 2.2}
"""Times of a Python that imports pydantic and yaml that a command takes at most; others have no goal."""


def start_s() -> float:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "bench.yaml").write_text(CONFIG)
        port = folder / "run" / "bench" / "m1"
        command = [HIL, "serve", str(folder / "bench.yaml"), "--runtime-dir", str(folder / "run")]
        began = time.perf_counter()
        process = subprocess.Popen(
            [*command, "--state-dir", str(folder / "state")],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            while True:
                try:
                    fd = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
                    os.write(fd, b"\n")
                    os.close(fd)
                    return time.perf_counter() - began
                except OSError:
                    if time.perf_counter() - began > 30:
                        raise
        finally:
            process.terminate()
            process.wait(10)


def start_cpu_s() -> float:
    """CPU time of `hil serve` of a board and doors, until it serves."""
    with daemon(WITH_BRIDGES) as running:
        return cpu_s(running.pid)


def import_s() -> float:
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", "import asyncio, yaml, pydantic, typer"], check=True)
    return time.perf_counter() - began


def cpu_ms(command: list[str]) -> float:
    """CPU time of a program, which other programs on the machine change less than its wall time."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, state, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(state)
    assert process.returncode == 0, f"{command} ended with {process.returncode}"
    return (used.ru_utime + used.ru_stime) * 1e3


def commands() -> None:
    """Print the CPU times of commands, in turns with the reference. A first run writes bytecode."""
    reference = [sys.executable, "-c", "import pydantic, yaml"]
    with daemon(CONFIG) as running:
        file = running.folder / "bridges.yaml"
        file.write_text(WITH_BRIDGES)
        tried = {
            "version": [HIL, "--version"],
            "completion": [HIL, "_names", "benches"],
            "list": [HIL, "list", "--runtime-dir", str(running.folder / "run")],
            "status": [HIL, "status", "--runtime-dir", str(running.folder / "run")],
            "check": [HIL, "check", str(running.folder / "bench.yaml")],
            "check_bridges": [HIL, "check", str(file)],
        }
        taken: dict[str, list[float]] = {name: [] for name in ("reference", *tried)}
        for _ in range(6 if is_quick() else 21):
            for name, command in {"reference": reference, **tried}.items():
                taken[name].append(cpu_ms(command))
    medians = {name: statistics.median(times[1:]) for name, times in taken.items()}
    for name in tried:
        extra = {"reference": "python -c 'import pydantic, yaml'", "runs_ms": taken[name][1:]}
        report(f"start_{name}", medians[name], "ms", medians["reference"], GOALS.get(name), extra)


def main() -> None:
    """Medians of alternating runs."""
    starts, imports = [], []
    for _ in range(5 if is_quick() else 15):
        starts.append(start_s())
        imports.append(import_s())
    value = statistics.median(starts)
    extra = {
        "reference": "a Python that imports asyncio, yaml, pydantic and typer, and ends",
        "limit_s": LIMIT_S,
        "holds": value <= LIMIT_S,
        "runs_s": starts,
    }
    report("start_up", value, "s", statistics.median(imports), None, extra)
    print(f"  to be at most {LIMIT_S:g} s: {'yes' if value <= LIMIT_S else 'NO'}")
    used = statistics.median(start_cpu_s() for _ in range(5 if is_quick() else 9))
    report("start_cpu", used, "s", CPU_LIMIT_S, 1.0, {"reference": "the limit: 0.7 s"})
    commands()


if __name__ == "__main__":
    main()
