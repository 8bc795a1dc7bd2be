"""Cost of an axis: ns for one control step of one axis, law, motor and encoder, beside plain C.

The core (``axis_cost.c``, compiled as the extension is) and ``reference_axis.c`` (compiled for this very
processor) take turns, so that a change of the machine's speed meets both; the figures are medians. Each axis
has its own table of 64 KiB, is in closed loop and is sent 45 degrees on every 650 control steps. ``full``
has four electrical steps in a control step, as the reference has here; ``simple`` is compared with the same
reference.

``axis_real_time_1000_*``: the share of a core that the real-time thread takes for 1000 axes at 6.5 kHz.

Needs a C compiler, as the installation from source does.
"""

import ast
import re
import shlex
import statistics
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from _report import check_work, is_quick, report

HERE = Path(__file__).parent
NATIVE = HERE.parent / "hil/core/native"
AXES = (1, 100, 1000, 2000)
PLANTS = ("simple", "full")
SUBSTEPS = 4
LIMIT_RATIO = 0.5
REAL_TIME_AXES, REAL_TIME_SHARE = 1000, 0.65
CONTROL_HZ = 48e6 / 7385
"""Rate of the Mechaduino's law."""
MOVE_TICKS = 650
"""Control steps between two set-points 45 degrees apart, in both programs."""
FOLLOWS_DEG = 15.0
"""Distance at which a set-point counts as reached; none of them is so near another."""


def core_flags() -> list[str]:
    """Flags with which the extension is compiled: Python's own, and those of ``setup.py``."""
    of_python = sysconfig.get_config_vars("CFLAGS", "CCSHARED")
    found = re.search(r"^CORE_FLAGS = (\(.*?^\))", (HERE.parent / "setup.py").read_text(), re.M | re.S)
    assert found, "setup.py has no CORE_FLAGS"
    ours = ast.literal_eval(found[1])
    return [*shlex.split(" ".join(of_python)), *ours, f"-I{NATIVE}"]


def build(folder: Path) -> tuple[str, str]:
    """The programs: (core, reference)."""
    core, reference = str(folder / "axis_cost"), str(folder / "reference_axis")
    sources = [path for path in NATIVE.rglob("*.c") if "tests" not in path.relative_to(NATIVE).parts]
    subprocess.run(
        ["cc", *core_flags(), str(HERE / "axis_cost.c"), *map(str, sources), "-lm", "-o", core], check=True
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
    """Time for a control step of the reference, whose first axis has to follow, too."""
    told = run(program, axes, ticks, SUBSTEPS)
    follows(float(told.split("axis 0 at")[1].split()[0]), ticks)
    return float(told.split(":")[1].split()[0])


def core_ns(program: str, axes: int, ticks: int, plant: str) -> float:
    """Time for a control step of the core: `axis_cost.c` prints it, the steps made, and where axis 0 is."""
    took_ns, made, position_deg = (
        float(word) for word in run(program, axes, ticks, plant, "virtual").split()
    )
    check_work("control steps", made, ticks, 0.02)
    follows(position_deg, ticks)
    return took_ns


def follows(position_deg: float, ticks: int) -> None:
    """Check that axis 0 has followed: ``ticks`` are whole moves, and it has ended the last of them."""
    wanted_deg = (ticks // MOVE_TICKS - 1) % 8 * 45
    if abs(position_deg - wanted_deg) > FOLLOWS_DEG:
        sys.exit(f"axis 0 is at {position_deg:.1f} deg instead of {wanted_deg}: the loop did not run")


def compare(programs: tuple[str, str], axes: int, axis_ticks: int, rounds: int) -> None:
    core, reference = programs
    ticks = MOVE_TICKS * max(axis_ticks // axes // MOVE_TICKS, 2)
    found: dict[str, list[float]] = {"reference": [], **{plant: [] for plant in PLANTS}}
    for turn in range(rounds):
        for kind in list(found) if turn % 2 else reversed(list(found)):
            if kind == "reference":
                found[kind].append(reference_ns(reference, axes, ticks))
            else:
                found[kind].append(core_ns(core, axes, ticks, kind))
    beside = statistics.median(found["reference"])
    for plant in PLANTS:
        report(
            f"axis_cost_{axes}" + ("" if plant == "full" else f"_{plant}"),
            statistics.median(found[plant]), "ns", beside, LIMIT_RATIO,
            {"reference": "reference_axis.c", "plant": plant, "axes": axes, "ticks": ticks,
             "runs": found[plant], "reference_runs": found["reference"]},
        )  # fmt: skip


def real_time(core: str, plant: str, run_s: int, rounds: int) -> None:
    shares = []
    for _ in range(rounds):
        share, steps_per_s = (float(word) for word in run(core, REAL_TIME_AXES, run_s, plant, "rt").split())
        check_work("control steps a second", steps_per_s, CONTROL_HZ, 0.02)
        shares.append(share)
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
