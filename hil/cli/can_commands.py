"""Commands ``hil can``."""

from typing import Annotated

import typer

from hil.cli.ask import Bench, RuntimeDir, ask_bench
from hil.cli.command_classes import Below
from hil.cli.told import CommandAnswer

can_app = typer.Typer(cls=Below, help="CANopen nodes.", no_args_is_help=True, rich_markup_mode=None)


@can_app.callback()
def _commands() -> None:
    pass


@can_app.command()
def eds(
    device: Annotated[str, typer.Argument(help="An axis with a node on a CAN bus.", show_default=False)],
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> CommandAnswer:
    """Print the electronic data sheet (EDS) of an axis's CANopen node, for the tools of masters.

    Example: hil can eds m1
    """
    answer = ask_bench(bench, runtime_dir, "eds", device=device)
    return CommandAnswer(answer, answer["text"].rstrip("\n"))
