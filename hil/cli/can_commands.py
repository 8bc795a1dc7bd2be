"""Commands ``hil can``."""

from typing import Annotated

import typer

from hil.cli.ask import Bench, RuntimeDir, ask_bench

can_app = typer.Typer(help="CANopen nodes.", no_args_is_help=True, rich_markup_mode=None)


@can_app.callback()
def _commands() -> None:
    pass


@can_app.command()
def eds(
    device: Annotated[str, typer.Argument(help="An axis with a node on a CAN bus.", show_default=False)],
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Print the electronic data sheet (EDS) of an axis's CANopen node, for the tools of masters."""
    typer.echo(ask_bench(bench, runtime_dir, "eds", device=device)["text"].rstrip("\n"))
