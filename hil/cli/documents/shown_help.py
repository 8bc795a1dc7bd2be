"""``hil help`` and ``hil version``: words that are typed without thinking."""

from typing import Annotated

import typer

from hil import __version__
from hil.cli.framework.ask import fail
from hil.cli.framework.exit_codes import Exit
from hil.vocab.near_words import meant


def help_of(
    context: typer.Context,
    command: Annotated[
        list[str] | None, typer.Argument(help="As in fault inject; left out: all.", show_default=False)
    ] = None,
) -> None:
    """Show the help of a command, as -h behind it does.

    Example: hil help run
    """
    here = context.parent
    assert here is not None
    for word in command or ():
        group = here.command
        below = group.get_command(here, word) if hasattr(group, "get_command") else None
        if below is None:
            names = group.list_commands(here) if hasattr(group, "list_commands") else []
            raise fail(f"hil: there is no command {word!r}; {meant(word, names)}", Exit.MISTAKE)
        here = type(context)(below, info_name=word, parent=here)
    typer.echo(here.get_help())


def version() -> None:
    """Print the version.

    Example: hil version
    """
    typer.echo(f"hil {__version__}")
