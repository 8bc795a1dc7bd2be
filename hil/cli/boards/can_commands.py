"""Commands ``hil can``."""

from typing import Annotated

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions
from hil.cli.framework.command_answers import CommandAnswer


def eds(
    device: Annotated[str, typer.Argument(help="An axis with a node on a CAN bus.", show_default=False)],
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Print the electronic data sheet (EDS) of an axis's CANopen node, for the tools of masters.

    Example: hil can eds m1
    """
    answer = bench.ask("eds", device=device)
    return CommandAnswer(answer, answer["text"].rstrip("\n"))
