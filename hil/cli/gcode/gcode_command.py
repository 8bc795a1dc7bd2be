"""``hil gcode``: a program in G-code, checked, planned and carried out."""

from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer, wants_json
from hil.cli.framework.exit_codes import Exit
from hil.cli.lines.named_lines import LineOptions

ProgramFile = Annotated[Path, typer.Argument(help="The program (RS-274/NGC).", show_default=False)]
MachineFile = Annotated[
    Path,
    typer.Option(
        "--machine", "-m", metavar="FILE", help="The machine's document (YAML).", show_default=False
    ),
]

if TYPE_CHECKING:
    from hil.toolpath.machine import Machine


class Executor(Enum):
    """Executor of a program."""

    LINE = "line"
    RUNS = "runs"


PATIENT_MS = 250.0
"""Time that an answer may take longer than on the line, on a computer that is busy: after that its motion may
be lost, and the program is stopped."""


def gcode(
    file: ProgramFile,
    machine: MachineFile,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Check and plan, and move nothing.")] = False,
    at: Annotated[
        str,
        typer.Option(
            "--at",
            metavar="POSITION",
            help="Where the machine stands, in machine coordinates, as 'X10 Y-2.5'. [default: 0]",
            show_default=False,
        ),
    ] = "",
    feed: Annotated[
        float, typer.Option("--feed", metavar="PERCENT", help="Feed override.", min=1, max=200)
    ] = 100.0,
    block_delete: Annotated[
        bool, typer.Option("--block-delete", help="Leave out lines that begin with a slash.")
    ] = False,
    by: Annotated[
        Executor | None,
        typer.Option(
            "--by",
            help="What carries it out: the line of the machine's SACs, or runs of the bench. [default: the"
            " line, if the machine has one]",
            show_default=False,
        ),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(
            "--plot",
            metavar="FILE",
            help="Draw the path asked for and the one followed (.png, .svg, .pdf).",
            show_default=False,
        ),
    ] = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Carry out a program of G-code: over the line of a machine's SACs, or by runs of a bench.

    First checks and plans all of it, and lists every problem with its line and column. Says how long the path
    is and takes, what is slowed down, and whether the line can keep up. On a terminal p pauses and resumes, s
    and Ctrl-C stop, S and a second Ctrl-C stop at once, + and - change the feed. Exits with 5 if it is not
    known where an axis stands, with 3 if the run failed, with 130 if you stopped it.

    Example: hil gcode drawing.ngc --machine mill.yaml --dry-run
    """
    from hil.cli.framework.problem_lines import tell_problems
    from hil.cli.gcode.gcode_files import (
        check_line,
        figures_of,
        figures_text,
        planned_file,
        position_of,
        read_machine,
        remarks_of,
    )
    from hil.cli.gcode.gcode_plot import FollowedAxes, check_plot, plotted

    made = read_machine(machine, file)
    by = by or (Executor.LINE if made.text.line is not None and made.has_nodes else Executor.RUNS)
    if by is Executor.RUNS and not dry_run:
        if at or block_delete:
            raise fail(
                "hil: runs begin where the axes stand, with all lines: leave out --at and --block-delete",
                Exit.MISTAKE,
            )
        return _by_runs(file, machine, made, feed, plot, bench)
    check_plot(plot, made)
    planned = planned_file(file, machine, at, override=feed / 100, is_block_delete=block_delete)
    if not wants_json() and (remarks := remarks_of(planned)):
        tell_problems("\n".join(remarks))
    check_line(planned)
    figures = figures_of(file, planned)
    text = figures_text(figures, planned.machine)
    if dry_run:
        return CommandAnswer(figures, text)
    if not wants_json():
        typer.echo(text, err=True)
    from hil.cli.gcode.gcode_line import carried_out, end_text

    begin = position_of(at, planned.machine)
    pulses = {axis.letter: axis.pulses_at(begin[axis.index]) for axis in planned.machine.axes}
    followed = FollowedAxes(planned.machine, bench) if plot else None
    if followed:
        followed.begin()
    of_line = planned.machine.text
    baud = of_line.baud if "baud" in of_line.model_fields_set else None  # else that of the tap
    end, code = carried_out(planned, LineOptions(baud, PATIENT_MS, bench=bench), pulses)
    text = end_text(str(file), end)
    if plot and followed:
        end["plot"] = plotted(plot, planned, begin, followed.end())
        text += f"\nwrote {plot}: largest deviation {end['plot']['largest_mm']:.3f} mm"
    return CommandAnswer(figures | {"run": end}, text, code)


def _by_runs(
    file: Path,
    machine_file: Path,
    machine: "Machine",
    feed: float,
    plot: Path | None,
    bench: BenchOptions,
) -> CommandAnswer:
    """Carry a program out by runs of a bench, which plans it from where its axes stand."""
    from hil.cli.framework.problem_lines import tell_problems
    from hil.cli.gcode.gcode_files import figures_of, figures_text, planned_at, remarks_of
    from hil.cli.gcode.gcode_plot import FollowedAxes, begin_of, check_plot, plotted
    from hil.cli.gcode.gcode_runs import RunsProgram, carried_by_runs, runs_text

    check_plot(plot, machine)
    if not machine.has_bench_axes:
        what = f"the machine {machine.name} has no axis: for each axis"
        raise fail(f"hil: {what}, which runs need", Exit.MISTAKE)
    begin = begin_of(machine, bench)
    planned = planned_at(file, machine, begin, override=feed / 100)
    if not wants_json() and (remarks := remarks_of(planned)):
        tell_problems("\n".join(remarks))
    figures = figures_of(file, planned)
    if not wants_json():
        typer.echo(figures_text(figures, machine), err=True)
    followed = FollowedAxes(machine, bench) if plot else None
    if followed:
        followed.begin()
    program = RunsProgram(bench, is_quiet=wants_json())
    texts = file.read_bytes().decode("utf-8", "replace"), machine_file.read_text("utf-8-sig")
    end, code = carried_by_runs(planned, texts, (str(file), str(machine_file)), feed, program)
    answer: dict[str, Any] = figures | {"runs": end["runs"]}
    text = runs_text(end)
    if plot and followed:
        answer["plot"] = plotted(plot, planned, begin, followed.end())
        text += f"\nwrote {plot}: largest deviation {answer['plot']['largest_mm']:.3f} mm"
    return CommandAnswer(answer, text, code)
