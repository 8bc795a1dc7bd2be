"""``hil mother gcode``: a program in G-code, checked, planned and carried out."""

from pathlib import Path
from typing import Annotated

import typer

from hil.cli.ask import fail
from hil.cli.exit_codes import Exit
from hil.cli.told import CommandAnswer, wants_json

ProgramFile = Annotated[Path, typer.Argument(help="The program (RS-274/NGC).", show_default=False)]
MachineFile = Annotated[
    Path,
    typer.Option(
        "--machine", "-m", metavar="FILE", help="The machine's document (YAML).", show_default=False
    ),
]


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
) -> CommandAnswer:
    """Check a program against a machine, and plan it.

    Lists every problem of the whole file with its line and column: words, limits, axes that are not there.
    Says what is slowed down, how long the path is and takes, and whether the line can keep up.

    Example: hil mother gcode drawing.ngc --machine mill.yaml --dry-run
    """
    if not dry_run:
        raise fail(
            "hil: write --dry-run: programs are checked and planned, and not carried out yet", Exit.MISTAKE
        )
    from hil.cli.gcode_files import check_line, figures_of, figures_text, planned_file, remarks_of
    from hil.cli.problem_lines import problems_shown

    planned = planned_file(file, machine, at, override=feed / 100, is_block_delete=block_delete)
    if not wants_json() and (remarks := remarks_of(planned)):
        typer.echo(problems_shown("\n".join(remarks)), err=True)
    check_line(planned)
    figures = figures_of(file, planned)
    return CommandAnswer(figures, figures_text(figures, planned.machine))
