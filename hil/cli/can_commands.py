"""Commands ``hil can``."""

from typing import Annotated

import typer

from hil.cli.ask import ANY_BENCH, BenchOptions
from hil.cli.command_classes import Below
from hil.cli.told import CommandAnswer

can_app = typer.Typer(cls=Below, help="CANopen nodes.", no_args_is_help=True, rich_markup_mode=None)


@can_app.callback()
def _commands() -> None:
    pass


@can_app.command()
def eds(
    device: Annotated[str, typer.Argument(help="An axis with a node on a CAN bus.", show_default=False)],
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Print the electronic data sheet (EDS) of an axis's CANopen node, for the tools of masters.

    Example: hil can eds m1
    """
    answer = bench.ask("eds", device=device)
    return CommandAnswer(answer, answer["text"].rstrip("\n"))
