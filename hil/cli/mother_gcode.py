"""``hil mother gcode``: a program in G-code, checked, planned and carried out."""

from pathlib import Path
from typing import Annotated

import typer

from hil.cli.ask import Bench, RuntimeDir
from hil.cli.mother_lines import LineOptions
from hil.cli.told import CommandAnswer, wants_json

ProgramFile = Annotated[Path, typer.Argument(help="The program (RS-274/NGC).", show_default=False)]
MachineFile = Annotated[
    Path,
    typer.Option(
        "--machine", "-m", metavar="FILE", help="The machine's document (YAML).", show_default=False
    ),
]

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
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> CommandAnswer:
    """Carry out a program over the line of a machine's SACs.

    First checks and plans all of it, and lists every problem with its line and column. Says how long the path
    is and takes, what is slowed down, and whether the line can keep up. On a terminal p pauses and resumes, s
    and Ctrl-C stop, S and a second Ctrl-C stop at once, + and - change the feed. Exits with 5 if it is not
    known where an axis stands, with 3 if the run failed, with 130 if you stopped it.

    Example: hil mother gcode drawing.ngc --machine mill.yaml --dry-run
    """
    from hil.cli.gcode_files import (
        check_line,
        figures_of,
        figures_text,
        planned_file,
        position_of,
        remarks_of,
    )
    from hil.cli.problem_lines import problems_shown

    planned = planned_file(file, machine, at, override=feed / 100, is_block_delete=block_delete)
    if not wants_json() and (remarks := remarks_of(planned)):
        typer.echo(problems_shown("\n".join(remarks)), err=True)
    check_line(planned)
    figures = figures_of(file, planned)
    text = figures_text(figures, planned.machine)
    if dry_run:
        return CommandAnswer(figures, text)
    if not wants_json():
        typer.echo(text, err=True)
    from hil.cli.gcode_line import carried_out, end_text

    begin = position_of(at, planned.machine)
    pulses = {axis.letter: axis.pulses_at(begin[axis.index]) for axis in planned.machine.axes}
    end, code = carried_out(planned, LineOptions(None, PATIENT_MS, None, bench, runtime_dir), pulses)
    return CommandAnswer(figures | {"run": end}, end_text(str(file), end), code)
