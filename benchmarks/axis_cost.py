"""Cost of an axis: ns for one control step of one axis, law, motor and encoder, beside plain C.

The core (``axis_cost.c``, compiled as the extension is) and ``reference_axis.c`` (compiled for this very
processor) take turns, so that a change of the machine's speed meets both; the figures are medians. Each axis
has its own table of 64 KiB, is in closed loop and is sent 45 degrees on every 650 control steps. ``full``
has four electrical steps in a control step, as the reference has here; ``simple`` is compared with the same
reference.

``axis_real_time_1000_*``: the share of a core that the real-time thread takes for 1000 axes at 6.5 kHz.

Needs a C compiler, as the installation from source does.
"""

import statistics
import subprocess
import tempfile
from pathlib import Path

from _report import is_quick, report

HERE = Path(__file__).parent
NATIVE = HERE.parent / "hil/core/native"
AXES = (1, 100, 1000, 2000)
PLANTS = ("simple", "full")
SUBSTEPS = 4
LIMIT_RATIO = 0.5
REAL_TIME_AXES, REAL_TIME_SHARE = 1000, 0.65
CORE_FLAGS = ["-std=gnu11", "-O3", "-ffp-contract=off", "-Wno-psabi", "-pthread", f"-I{NATIVE}"]
"""Compiler flags of the core, as in ``setup.py``."""


def build(folder: Path) -> tuple[str, str]:
    """The programs: (core, reference)."""
    core, reference = str(folder / "axis_cost"), str(folder / "reference_axis")
    sources = [*NATIVE.glob("*.c"), *(path for path in NATIVE.glob("*/*.c") if path.parent.name != "tests")]
    subprocess.run(
        ["cc", *CORE_FLAGS, str(HERE / "axis_cost.c"), *map(str, sources), "-lm", "-o", core], check=True
    )
    flags = ["-O3", "-march=native"]
    subprocess.run(["cc", *flags, str(HERE / "reference_axis.c"), "-lm", "-o", reference], check=True)
    return core, reference


def run(*command: object) -> str:
    line = [str(part) for part in command]
    return subprocess.run(
        line, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ).stdout


def reference_ns(program: str, axes: int, ticks: int) -> float:
    return float(run(program, axes, ticks, SUBSTEPS).split(":")[1].split()[0])


def compare(programs: tuple[str, str], axes: int, axis_ticks: int, rounds: int) -> None:
    core, reference = programs
    ticks = max(axis_ticks // axes, 650)
    found: dict[str, list[float]] = {"reference": [], **{plant: [] for plant in PLANTS}}
    for turn in range(rounds):
        for kind in list(found) if turn % 2 else reversed(list(found)):
            if kind == "reference":
                found[kind].append(reference_ns(reference, axes, ticks))
            else:
                found[kind].append(float(run(core, axes, ticks, kind)))
    beside = statistics.median(found["reference"])
    for plant in PLANTS:
        report(
            f"axis_cost_{axes}" + ("" if plant == "full" else f"_{plant}"),
            statistics.median(found[plant]), "ns", beside, LIMIT_RATIO,
            {"reference": "reference_axis.c", "plant": plant, "axes": axes, "ticks": ticks,
             "runs": found[plant], "reference_runs": found["reference"]},
        )  # fmt: skip


def real_time(core: str, plant: str, run_s: int, rounds: int) -> None:
    shares = [float(run(core, REAL_TIME_AXES, run_s, plant, "rt")) for _ in range(rounds)]
    report(
        f"axis_real_time_{REAL_TIME_AXES}_{plant}", statistics.median(shares), "core", 1.0, REAL_TIME_SHARE,
        {"reference": "one core", "plant": plant, "seconds": run_s, "runs": shares},
    )  # fmt: skip


def main() -> None:
    quick = is_quick()
    axis_ticks, rounds, run_s = (300_000, 1, 1) if quick else (3_000_000, 7, 5)
    with tempfile.TemporaryDirectory() as folder:
        programs = build(Path(folder))
        for axes in AXES:
            compare(programs, axes, axis_ticks, rounds)
        for plant in PLANTS:
            real_time(programs[0], plant, run_s, 1 if quick else 3)


if __name__ == "__main__":
    main()
