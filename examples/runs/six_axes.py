"""A run of six axes in simulated time: four servos and two steppers, from pick_and_place.yaml.

`python six_axes.py run.png` draws all of them (needs the extra `plot`).
"""

import sys
from pathlib import Path

from hil.runs import Progress, parse_run
from hil.telemetry import Recording
from hil.testing import Bench

RUN = Path(__file__).with_name("pick_and_place.yaml")
SERVOS = ("base", "shoulder", "elbow", "wrist")
STEPPERS = ("gripper", "conveyor")
WANTED_AND_REAL = {"servo": ("r", "yw"), "stepper": ("commanded_deg", "position_deg")}
SAC = {"profile": "sac"}
MECHADUINO = {"profile": "mechaduino", "flash": {"table": "identity"}}


def ready() -> Bench:
    """Bench whose boards have all started, and whose servos hold 0 degrees."""
    devices = dict.fromkeys(SERVOS, MECHADUINO) | dict.fromkeys(STEPPERS, SAC)
    bench = Bench({"bench": "six", "devices": devices})
    bench.run(ms=4100)
    for name in SERVOS:
        bench.axis(name).do("enable")
        bench.axis(name).do("move_abs", position_deg=0)
    bench.run(ms=1000)
    return bench


def perform(bench: Bench) -> tuple[Progress, dict[str, Recording], list[float]]:
    """Carry the run out; how it went, the angles of each axis, and when each step began, in seconds."""
    recordings = {name: bench.axis(name).record(*WANTED_AND_REAL["servo"], interval_ms=2) for name in SERVOS}
    recordings |= {
        name: bench.axis(name).record(*WANTED_AND_REAL["stepper"], interval_ms=2) for name in STEPPERS
    }
    execution = bench.execute(RUN.read_text())
    start_ns = bench.now_ns
    begun_s: list[float] = []
    for until_ns in execution.run():
        if execution.progress.step > len(begun_s):
            begun_s.append((bench.now_ns - start_ns) / 1e9)
        bench.run_until(until_ns / 1e6)
    bench.run(ms=200)
    return execution.progress, recordings, begun_s


def draw(recordings: dict[str, Recording], begun_s: list[float], path: Path) -> None:
    """Draw a row for each axis: where it should be and is, and the difference."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 11), layout="constrained")
    panels = figure.subplots(len(recordings), 2, sharex=True, width_ratios=(3, 2))
    for row, (name, recording) in zip(panels, recordings.items(), strict=True):
        at_s = recording.at_s()
        wanted, real = (recording.column(signal) for signal in recording.signals)
        angle, error = row
        angle.plot(at_s, real, color="C0", linewidth=1.8, label="shaft")
        angle.plot(at_s, wanted, color="black", linewidth=1.0, linestyle="--", label="set-point")
        error.plot(at_s, [w - r for w, r in zip(wanted, real, strict=True)], color="C3", linewidth=1.0)
        kind = "servo" if name in SERVOS else "stepper"
        angle.set_ylabel(f"{name}\n({kind})", rotation=0, ha="right", va="center")
        error.yaxis.tick_right()
        for panel in row:
            panel.grid(alpha=0.25)
            panel.margins(x=0)
            for when_s in begun_s:
                panel.axvline(when_s, color="gray", linewidth=0.8, linestyle=":")
    heads = ("angle [deg]", "set-point minus shaft [deg]")
    for panel, head in zip(panels[0], heads, strict=True):
        panel.set_title(head, fontsize="medium", pad=34)
    run, _ = parse_run(RUN.read_text(), RUN.name)
    for when_s, label in zip(begun_s, (step.label or "" for step in run.steps), strict=True):
        panels[0][0].annotate(
            label, (when_s, 1), (2, 4), xycoords=("data", "axes fraction"), textcoords="offset points",
            rotation=35, fontsize="small", color="dimgray",
        )  # fmt: skip
    panels[0][0].legend(loc="lower left", fontsize="small")
    for panel in panels[-1]:
        panel.set_xlabel("simulated time [s]")
    figure.suptitle("A run of six axes in simulated time: pick and place by four servos and two steppers")
    figure.savefig(path, dpi=90)


def main() -> None:
    progress, recordings, begun_s = perform(ready())
    print(f"{progress.run}: {progress.state}, {progress.steps} steps")
    for name, axis in progress.axes.items():
        is_at_deg = round(axis.position_deg, 2) + 0.0  # 0.0 for what rounds to -0.0
        print(
            f"  {name:8} at {is_at_deg:7.2f} deg, planned {axis.target_deg:7.2f};"
            f" following error at most {axis.error_max_deg:.3f}, rms {axis.error_rms_deg:.3f} deg"
        )
    if len(sys.argv) > 1:
        draw(recordings, begun_s, Path(sys.argv[1]))


if __name__ == "__main__":
    main()
