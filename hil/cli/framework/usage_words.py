"""Words of usage lines, and the class of errors of a command line."""

import re
from typing import Any

import typer

from hil.cli.framework.command_table import VALUES

USAGE_ERROR: type[Any] = typer.BadParameter.__mro__[1]
"""Error of a wrong command line: click's, or that of typer's own copy of it."""


def placeholder(name: str) -> str:
    """Placeholder for the value of an option or an argument, by the parameter's name."""
    row = VALUES.get(name)
    return row.placeholder if row and row.placeholder else name.upper().replace("_", "-")


_FIRST = re.compile(r"(?:(?P<of>[\w.-]+): )?[^\n`]*\b(?P<verb>enable|disable|calibrate|stop) it first")


def with_command(why: str, device: str = "") -> str:
    """Refusal of a board with the command for what it wants first, as of "m1: ...; enable it first".
    ``device``: where it does not begin with its name."""
    found = _FIRST.fullmatch(why)
    if not found or not (of := device or found["of"]):
        return why
    return f"{why}: `hil stop {of}`" if found["verb"] == "stop" else f"{why}: `hil axis {of} {found['verb']}`"


def usage_word(argument: Any) -> str:
    """Argument as a usage line has it: DEVICE, [VERB], [VALUE...]."""
    word = (argument.metavar or placeholder(argument.name)).removesuffix("...")
    word += "..." * (argument.nargs == -1)
    return word if argument.required else f"[{word}]"
