"""``hil with-lines``: another program, for which ptys have modem lines."""

import os
import signal
from typing import Annotated

import typer

from hil.cli.ask import fail
from hil.cli.exit_codes import Exit

_IGNORED_BY_PYTHON = (signal.SIGPIPE, signal.SIGXFSZ)


def with_lines(
    program: Annotated[list[str], typer.Argument(help="A program, and what it is given.")],
) -> None:
    """Start a program for which pseudo-terminals have modem lines.

    For programs that refuse a port without them, as CuteCom and GTKTerm, or that set DTR and RTS. They read
    DTR and RTS as they set them, and CTS, DSR and carrier as on. The lines end in the program: the board
    does not notice them, nor do other programs.

    It works by a library that the program loads (LD_PRELOAD), and so do the programs that it starts. A
    program that is linked statically, as those in Go, or that runs with the rights of another user (set-id)
    loads none. The exit code is the program's.

    Example: hil with-lines cutecom
    """
    from hil.host.preload import PreloadRefused, find_program, with_library

    try:
        path, env = find_program(program[0], os.environ), with_library(os.environ)
    except PreloadRefused as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None
    for number in _IGNORED_BY_PYTHON:
        signal.signal(number, signal.SIG_DFL)
    try:
        os.execve(path, program, env)
    except OSError as error:
        raise fail(f"hil: {path}: {error.strerror}", Exit.MISTAKE) from None
