"""``hil docs``, ``hil completion`` and ``hil reference``."""

from typing import Annotated

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer


def docs(
    topic: Annotated[
        str | None, typer.Argument(help="A page's name, as in runs; left out: list all.", show_default=False)
    ] = None,
) -> CommandAnswer:
    """Print a page of the documentation, or list the pages.

    Example: hil docs runs
    """
    from hil.cli.framework.installed_files import find_pages
    from hil.vocab.near_words import meant

    pages = find_pages()
    if not pages:
        raise fail("hil: this installation has no pages")
    if topic is None:
        width = max(map(len, pages))
        rows = {name: page.title for name, page in pages.items()}
        return CommandAnswer(rows, "\n".join(f"{name:{width}}  {title}" for name, title in rows.items()))
    name = topic.rpartition("/")[2].partition("#")[0].removesuffix(".md")
    if name not in pages:
        raise fail(f"hil: there is no page {topic!r}; {meant(name, pages, '`hil docs` lists them')}", 2)
    text = pages[name].file.read_text()
    return CommandAnswer({"topic": name, "file": str(pages[name].file), "text": text}, text.rstrip("\n"))


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
) -> None:
    """Print the reference of configuration, commands, control verbs and axis fields as Markdown."""
    from hil.cli.documents.man import man_page
    from hil.cli.documents.reference import reference as text
    from hil.cli.framework.command_group import app

    typer.echo(man_page(app) if man else text(app), nl=False)
