"""Drawings on a bench of the kit: the path asked for against the one that its axes follow."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from hil.gcode.canonical import Point, Settings
from hil.gcode.reader import read_program
from hil.runs import Progress
from hil.telemetry import Recording
from hil.telemetry.path_picture import path_drawn
from hil.testing.bench import Bench
from hil.toolpath.bench_runs import BenchRuns, machine_problems
from hil.toolpath.deviation import Deviation, asked_path, asked_rapids, deviation, zero_shift_deg
from hil.toolpath.machine import Machine, parse_machine
from hil.toolpath.path_items import Position
from hil.toolpath.path_plan import plan_program
from hil.vocab.problem import ConfigError


@dataclass(frozen=True)
class FollowedPath:
    """Path that was asked for, and the one that the axes followed, in the machine's positions."""

    machine: Machine
    asked: Sequence[Position]
    followed: Sequence[Position]
    progress: Sequence[Progress] = ()
    """Reports of the runs that carried it out; none where something else did."""
    rapids: Sequence[bool] = ()
    """Truth of "a rapid leads here" for each place that was asked for; empty: it is not known."""

    @property
    def deviation(self) -> Deviation:
        """Largest distance between both."""
        return deviation(self.asked, self.followed)

    def picture(self, suffix: str = ".png", title: str = "") -> bytes:
        """Draw both, with the largest deviation; ``suffix`` is .png, .svg or .pdf.

        Raises:
            PictureError: matplotlib is not installed.
        """
        letters = "".join(axis.letter for axis in self.machine.axes)
        found = self.deviation
        notes = f"largest deviation {found.largest:.3f} mm"
        return path_drawn(
            self.asked,
            self.followed,
            letters,
            suffix,
            course=found.course,
            rapids=self.rapids,
            title=title,
            notes=notes,
        )


def draw_by_runs(
    bench: Bench, program: bytes | Path, machine: Path | str, override: float = 1.0
) -> FollowedPath:
    """Carry out a program in G-code by runs of the bench, from where its axes stand; pauses (M0) take no
    time.

    Raises:
        ConfigError: it cannot be done, with all problems.
    """
    file, data = _file_of(program)
    machine_file, text = _file_of(machine if isinstance(machine, Path) else machine.encode())
    made = parse_machine(text.decode(), machine_file)
    axes = bench.run_axes
    if problems := machine_problems(made, machine_file, axes):
        raise ConfigError(problems)
    begin = Point(
        **{
            axis.letter: (axes[str(axis.bench_axis)].position_deg - axis.zero_deg) / axis.motor_deg_per_unit
            for axis in made.axes
        }
    )
    read = read_program(data, Settings(file, begin))
    plan = plan_program(read, made, file, begin, override)
    runs = BenchRuns(plan, axes)
    if problems := [*plan.problems, *runs.problems]:
        raise ConfigError(problems)
    progress: list[Progress] = []

    def carry_out() -> None:
        for run in runs.runs:
            progress.append(bench.perform(run.text))
            bench.run(1)  # a path ends with the control step after its last time

    followed = followed_by(bench, made, carry_out)
    asked, rapids = asked_path(read.motions, made, begin), asked_rapids(read.motions, begin)
    return FollowedPath(made, asked, followed, progress, rapids)


def followed_by(
    bench: Bench, machine: Machine, carry_out: Callable[[], object], interval_ms: float = 1.0
) -> list[Position]:
    """Positions of a machine's axes while something is carried out, whatever moves them. Each axis needs its
    axis of the bench (``axis:``)."""
    axes = [bench.axis(str(axis.bench_axis)) for axis in machine.axes]
    recordings = [axis.record("position_deg", interval_ms=interval_ms) for axis in axes]
    shifts_deg = [zero_shift_deg(axis.snapshot().as_dict()) for axis in axes]
    carry_out()
    return positions_of(machine, recordings, shifts_deg)


def positions_of(
    machine: Machine, recordings: Sequence[Recording], shifts_deg: Sequence[float] | None = None
) -> list[Position]:
    """Positions that recordings of ``position_deg`` mean, one for each axis of the machine. ``shifts_deg``:
    the zeros of their boards less those of their shafts."""
    columns = [
        [
            (place + shift_deg - axis.zero_deg) / axis.motor_deg_per_unit
            for place in recording.column("position_deg")
        ]
        for axis, recording, shift_deg in zip(
            machine.axes, recordings, shifts_deg or [0.0] * len(recordings), strict=True
        )
    ]
    return list(zip(*columns, strict=False))


def _file_of(given: bytes | Path) -> tuple[str, bytes]:
    return (str(given), given.read_bytes()) if isinstance(given, Path) else ("program", given)
