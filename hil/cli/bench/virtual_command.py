"""The command that runs a program on the simulated time of a bench."""

import os
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.exit_codes import Exit
from hil.host.python_program import NoPythonProgram, find_python_program

FIRST_DATE = datetime(2026, 1, 1, tzinfo=UTC)
"""Date at which a program starts by default: the same in each run."""


def virtual(
    bench: Annotated[Path, typer.Argument(help="Configuration of the bench.")],
    program: Annotated[list[str], typer.Argument(help="A Python program, and what it is given.")],
    mapped: Annotated[
        list[str],
        typer.Option("--map", help="NAME=PORT: a name that the program opens, and its port. Repeatable."),
    ] = [],  # noqa: B006 - typer's way for an option that can be repeated
    module: Annotated[
        bool, typer.Option("--module", "-m", help="PROGRAM is a module, as of python -m.")
    ] = False,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the bench's chance.")] = 0,
    date: Annotated[
        str, typer.Option("--date", help="Date at which it starts, as 2026-01-31T12:00:00 (UTC), or now.")
    ] = FIRST_DATE.strftime("%Y-%m-%dT%H:%M:%S"),
) -> None:
    """Run a program on the simulated time of a bench, as fast as it goes.

    The program is not changed: pyserial's ports are those of the bench, by their names or by --map, and its
    clocks, sleeps, threads, locks, timers and waits are on simulated time. It starts when the boards answer.
    Time passes when all of its threads wait, so it does the same each time. What is outside has the wall's
    time, such as child processes and network connections; this is said. The exit code is the program's.

    Example: hil virtual bench.yaml --map /dev/ttyUSB0=m1 home.py /dev/ttyUSB0
    """
    for each in mapped:
        if not all(each.rpartition("=")[::2]):
            raise fail(f"--map: {each!r} is no path and port; write them as in /dev/ttyUSB0=m1", Exit.MISTAKE)
    if not bench.exists():
        raise fail(f"{bench}: there is no such file; `hil init {bench}` writes one", Exit.MISTAKE)
    try:
        path = program[0] if module else find_python_program(program[0])
    except NoPythonProgram as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None
    options = [*(word for each in mapped for word in ("--map", each)), "--seed", str(seed)]
    options += ["--date", str(_date(date).timestamp()), *(["--module"] if module else [])]
    run = [sys.executable, "-m", "hil.testing.owned_time.program", *options, "--", str(bench), path]
    os.execv(sys.executable, [*run, *program[1:]])


def _date(text: str) -> datetime:
    if text == "now":
        return datetime.now(UTC)
    try:
        read = datetime.fromisoformat(text)
    except ValueError:
        raise fail(f"hil: --date {text}: write it as 2026-01-31T12:00:00, or now", Exit.MISTAKE) from None
    return read if read.tzinfo else read.replace(tzinfo=UTC)
