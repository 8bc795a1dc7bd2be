"""``hil help`` and ``hil version``: words that are typed without thinking."""

import shlex
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
    """Show the help of a command, as -h behind it does; of another word, the tasks that have it.

    Example: hil help run

    Example: hil help wireshark
    """
    here = context.parent
    assert here is not None
    for word in command or ():
        group = here.command
        below = group.get_command(here, word) if hasattr(group, "get_command") else None
        if below is None:
            if here is context.parent and (found := _of_word(word)):
                typer.echo(found)
                return
            names = group.list_commands(here) if hasattr(group, "list_commands") else []
            there = "" if names else f"`{here.command_path}` has none below it"
            if here is context.parent:
                there = f"`hil help` lists them, and `hil docs {shlex.quote(word)}` searches the pages"
            raise fail(f"there is no command {word!r}; {meant(word, names, there)}", Exit.MISTAKE)
        here = type(context)(below, info_name=word, parent=here)
    typer.echo(here.get_help())


def _of_word(word: str) -> str:
    """Lines for a word that is no command: the command that it stands for, tasks that have it; or empty."""
    from hil.cli.documents.tasks import tasks_about
    from hil.cli.framework.guessed_words import guessed
    from hil.cli.framework.shown_view import Grid, ShownView, line

    rows = [(task.want, task.line) for task in tasks_about(word)]
    if meaning := guessed(word):
        said = f"There is no command `{word}`; `hil {meaning}` is meant."
    elif rows:
        said = f"There is no command `{word}`. Tasks with this word, and what to type:"
    else:
        return ""
    columns = ("what you want", "what you type")
    table = [Grid(columns, columns, rows, prose=columns[:1])] if rows else []
    return ShownView(line(said, wraps=True), *table).text()


def version() -> None:
    """Print the version.

    Example: hil version
    """
    typer.echo(f"hil {__version__}")
