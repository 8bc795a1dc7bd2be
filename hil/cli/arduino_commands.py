"""``hil arduino``, and the two programs that the IDE starts."""

import os
import shutil
import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from hil.cli.ask import fail
from hil.cli.command_classes import Below

ABOUT = """\
The Arduino IDE 2 and arduino-cli ask helper programs where boards are, and how to talk to them.

  hil arduino install      writes hardware/hil/virtual into your sketchbook, which names hil's helpers.
                           Restart the IDE: the devices of running benches are among its ports, and the
                           serial monitor and plotter work.
  hil arduino uninstall    removes it.

With arduino-cli:

  arduino-cli board list
  arduino-cli monitor -p ADDRESS -l hil -b hil:virtual:mechaduino

An IDE that knows real terminals only (1.8, or 2 without this) does not list virtual ports, and its serial
monitor refuses a pseudo-terminal, for it has no modem lines. Use `hil monitor DEVICE` beside it.

A sketch cannot be uploaded: the board runs its own firmware. Closing a port at 1200 baud, as an upload
begins, resets a board with native USB, and it boots as usual."""

Sketchbook = Annotated[
    Path | None,
    typer.Option("--sketchbook", help="The Arduino sketchbook. [default: that of the IDE's settings]"),
]
RuntimeDir = Annotated[
    Path | None,
    typer.Option(
        "--runtime-dir", help="Folder of running benches' ports and sockets. [default: $XDG_RUNTIME_DIR/hil]"
    ),
]

app = typer.Typer(
    cls=Below, rich_markup_mode=None, help="Show the devices to the Arduino IDE 2 and arduino-cli."
)


@app.callback(invoke_without_command=True)
def about(context: typer.Context) -> None:
    """Show devices in the Arduino IDE 2 and arduino-cli; alone, it explains how."""
    if context.invoked_subcommand is None:
        typer.echo(ABOUT)


@app.command()
def install(sketchbook: Sketchbook = None, runtime_dir: RuntimeDir = None) -> None:
    """Add hil to the IDE, by a folder in the sketchbook.

    With --runtime-dir the IDE looks for benches there.

    Example: hil arduino install
    """
    from hil.arduino.install import InstallError, boards_txt, platform_txt
    from hil.arduino.install import install as write
    from hil.compose import find_catalogue

    arguments = ["--runtime-dir", str(runtime_dir.absolute())] if runtime_dir else []
    try:
        files = {
            "platform.txt": platform_txt(_program(), arguments),
            "boards.txt": boards_txt(find_catalogue().profiles.values()),
        }
        book = _sketchbook(sketchbook)
        written = write(book, files)
    except InstallError as error:
        raise fail(f"hil: {error}") from None
    for path in written:
        typer.echo(f"wrote {path}")
    typer.echo("Restart the IDE." if written else f"Nothing to do: {book} has it all.")


@app.command()
def uninstall(sketchbook: Sketchbook = None) -> None:
    """Remove what `hil arduino install` wrote.

    Example: hil arduino uninstall
    """
    from hil.arduino.install import InstallError
    from hil.arduino.install import uninstall as remove

    book = _sketchbook(sketchbook)
    try:
        removed = remove(book, ("platform.txt", "boards.txt"))
    except InstallError as error:
        raise fail(f"hil: {error}") from None
    for path in removed:
        typer.echo(f"removed {path}")
    if not removed:
        typer.echo(f"Nothing to do: {book} has nothing of hil.")


def discovery(runtime_dir: RuntimeDir = None) -> None:
    """The IDE's discovery: commands on standard input, JSON on standard output."""
    from hil.arduino.discovery import discover
    from hil.host.paths import runtime_bases

    with suppress(KeyboardInterrupt):
        discover(runtime_bases(runtime_dir, os.environ), 0, sys.stdout, runtime_dir is not None)


def monitor() -> None:
    """The IDE's serial monitor: commands on standard input, JSON on standard output."""
    from hil.arduino.monitor import serve

    with suppress(KeyboardInterrupt):
        serve(0, sys.stdout)


def _sketchbook(option: Path | None) -> Path:
    from hil.arduino.install import find_sketchbook

    return find_sketchbook(option, os.environ, Path.home())


def _program() -> Path:
    """Path of this installation's ``hil``: beside its Python, or else the one that was typed."""
    beside = Path(sys.executable).with_name("hil")
    return beside if beside.exists() else Path(shutil.which(sys.argv[0]) or sys.argv[0]).absolute()
