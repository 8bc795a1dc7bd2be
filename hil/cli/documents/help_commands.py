"""``hil completion`` and ``hil reference``."""

from typing import Annotated

import typer

from hil.cli.framework.ask import fail


def completion(
    shell: Annotated[str, typer.Argument(help="bash, zsh or fish.", show_default=False)],
) -> None:
    """Print a completion script for a shell.

    For bash in ~/.bashrc: source <(hil completion bash)

    Example: hil completion zsh
    """
    from hil.cli.documents.command_tree import commands
    from hil.cli.documents.completion import SHELLS
    from hil.cli.framework.command_group import app

    if shell not in SHELLS:
        raise fail(f"hil: there is no completion for {shell!r}; there is for {', '.join(SHELLS)}", 2)
    typer.echo(SHELLS[shell](commands(app)), nl=False)


def reference(
    man: Annotated[bool, typer.Option("--man", help="The man page instead.")] = False,
    commands: Annotated[bool, typer.Option("--commands", help="The page of commands instead.")] = False,
) -> None:
    """Print the reference of configuration, commands, control verbs and axis fields as Markdown."""
    from hil.cli.documents.command_page import command_page
    from hil.cli.documents.man import man_page
    from hil.cli.documents.reference import reference as text
    from hil.cli.framework.command_group import app

    typer.echo(man_page(app) if man else command_page(app) if commands else text(app), nl=False)
