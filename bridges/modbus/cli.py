"""Commands ``hil modbus``."""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from bridges.modbus.door.cycle_command import cycle

app = typer.Typer(
    name="modbus",
    help="Register maps, and times of polls on a line.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.callback(rich_help_panel="Wire")
def _commands() -> None:
    pass


app.command("cycle")(cycle)


@app.command("map")
def print_map(
    device: Annotated[str, typer.Argument(help="A device, or an axis of one.", show_default=False)],
    form: Annotated[str, typer.Option("--format", help="table, csv, markdown or json.")] = "table",
    bench: Annotated[
        str | None,
        typer.Option(
            "--bench",
            "-b",
            help="The bench, by its name, its folder or service:NAME; needed when several are running.",
        ),
    ] = None,
    runtime_dir: Annotated[
        Path | None,
        typer.Option(
            "--runtime-dir",
            help="Folder of running benches' ports and sockets."
            " [default: $XDG_RUNTIME_DIR/hil; commands that ask look in /run/hil too]",
        ),
    ] = None,
) -> None:
    """Print the register map of a device of a running bench.

    Numbers are those in a request: register 0 is the first.

    Example: hil modbus map m1
    """
    import os
    import shutil

    from bridges.modbus.registers.map_rows import FORMATS, formatted, wrapped
    from hil.net.benches_here import find
    from hil.net.control_client import ControlError, ask

    if form not in FORMATS:
        typer.echo(f"hil: --format {form}: formats are {', '.join(FORMATS)}", err=True)
        raise typer.Exit(2)
    found = find(runtime_dir, os.environ).running()
    meant = found.meant(bench)
    if not found.benches:
        typer.echo(f"hil: {found.none_runs()}", err=True)
        raise typer.Exit(1)
    if len(meant) != 1:
        names = ", ".join(found.called(each) for each in found.benches)
        typer.echo(f"hil: which bench? --bench names one; running: {names}", err=True)
        raise typer.Exit(2 if meant else 1)
    try:
        answer = ask(meant[0].socket, "registers", device=device)
        status = ask(meant[0].socket, "status")["bridges"].get("modbus", {}) if form == "table" else {}
    except ControlError as error:
        typer.echo(f"hil: {error}", err=True)
        raise typer.Exit(2 if error.is_mistake else 1) from None
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    for number, addresses in _addresses(status, answer["device"]).items():
        for line in wrapped(f"{answer['device']} is unit {number} at {', '.join(addresses)}", width):
            typer.echo(line)
    for line in formatted(answer, form, width):
        typer.echo(line)


def _addresses(status: Mapping[str, Any], axis: str) -> dict[str, list[str]]:
    """Addresses at which an axis is there, by the number that it has at them."""
    found: dict[str, list[str]] = {}
    for address in status.get("listen", ()):
        units = status["lines"].get(address, status)["units"]
        for number in (number for number, name in units.items() if name == axis):
            found.setdefault(number, []).append(address)
    return found
