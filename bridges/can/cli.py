"""Commands ``hil can``."""

from typing import Annotated, Any

import typer

from hil.vocab.profile import AskBench

app = typer.Typer(
    name="can",
    help="CANopen nodes.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.callback(rich_help_panel="Wire")
def _commands() -> None:
    pass


@app.command()
def eds(
    device: Annotated[str, typer.Argument(help="An axis with a node on a CAN bus.", show_default=False)],
    ask: AskBench,
) -> tuple[Any, str]:
    """Print the electronic data sheet (EDS) of an axis's CANopen node, for the tools of masters.

    Example: hil can eds m1
    """
    answer = ask("eds", device=device)
    return answer, answer["text"].rstrip("\n")
