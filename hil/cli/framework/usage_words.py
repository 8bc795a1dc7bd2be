"""Words of usage lines, and the class of errors of a command line."""

from typing import Any

import typer

from hil.cli.framework.command_table import VALUES

USAGE_ERROR: type[Any] = typer.BadParameter.__mro__[1]
"""Error of a wrong command line: click's, or that of typer's own copy of it."""


def placeholder(name: str) -> str:
    """Placeholder for the value of an option or an argument, by the parameter's name."""
    row = VALUES.get(name)
    return row.placeholder if row and row.placeholder else name.upper().replace("_", "-")


def usage_word(argument: Any) -> str:
    """Argument as a usage line has it: DEVICE, [VERB], [VALUE...]."""
    word = (argument.metavar or placeholder(argument.name)).removesuffix("...")
    word += "..." * (argument.nargs == -1)
    return word if argument.required else f"[{word}]"
