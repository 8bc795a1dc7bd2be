"""``hil arduino``, and the two programs that the IDE starts."""

import os
import shutil
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.progress_bars import bar

ABOUT = """\
The Arduino IDE, 2 and 1.8 (from 1.8.9), and arduino-cli ask helper programs where boards are.

  hil arduino install      writes hardware/hil/virtual into the sketchbook of each IDE here, which names
                           hil's helpers. Restart the IDE: the devices of running benches are among its
                           ports, and the serial monitor and plotter work.
  hil arduino uninstall    removes it.

With arduino-cli:

  arduino-cli board list
  arduino-cli monitor -p ADDRESS -l hil -b hil:virtual:mechaduino

The IDE 1.8 lists pseudo-terminals, and no sockets. When it opens one, it says in its console "Error while
setting serial port parameters": the port has no modem lines, and works. `hil with-lines arduino` starts an
IDE 1.8 that does not say so.

A sketch cannot be uploaded: the board runs its own firmware. Closing a port at 1200 baud, as an upload
begins, resets a board with native USB, and it boots as usual."""

Sketchbook = Annotated[
    Path | None,
    typer.Option("--sketchbook", help="The Arduino sketchbook. [default: those of the IDEs' settings]"),
]
RuntimeDir = Annotated[
    Path | None,
    typer.Option(
        "--runtime-dir", help="Folder of running benches' ports and sockets. [default: $XDG_RUNTIME_DIR/hil]"
    ),
]

Ide18 = Annotated[bool, typer.Option("--ide-1.8", help="Speak as the IDE 1.8 does, which says no HELLO.")]


def about(context: typer.Context) -> None:
    """Show devices in the Arduino IDE and arduino-cli; alone, it explains how."""
    if context.invoked_subcommand is None:
        typer.echo(ABOUT)


def install(sketchbook: Sketchbook = None, runtime_dir: RuntimeDir = None) -> None:
    """Add hil to each IDE here, by a folder in its sketchbook.

    With --runtime-dir the IDE looks for benches there.

    Example: hil arduino install
    """
    from hil.arduino.install import InstallError, boards_txt, platform_txt
    from hil.arduino.install import install as write
    from hil.arduino.sketchbooks import find_sketchbooks
    from hil.compose import find_catalogue

    arguments = ["--runtime-dir", str(runtime_dir.absolute())] if runtime_dir else []
    try:
        with bar("boards for the IDE are described"):
            files = {
                "platform.txt": platform_txt(_program(), arguments),
                "boards.txt": boards_txt(find_catalogue().profiles.values()),
            }
    except InstallError as error:
        raise fail(f"hil: {error}") from None
    books = find_sketchbooks(sketchbook, os.environ, Path.home())
    written = _in_each(books, "wrote", lambda book: write(book, files))
    typer.echo("Restart the IDE." if written else f"Nothing to do in {_listed(books)}.")


def uninstall(sketchbook: Sketchbook = None) -> None:
    """Remove what `hil arduino install` wrote.

    Example: hil arduino uninstall
    """
    from hil.arduino.install import uninstall as remove
    from hil.arduino.sketchbooks import default_sketchbook, named_sketchbooks

    default = default_sketchbook(Path.home())
    named = [sketchbook.absolute()] if sketchbook else named_sketchbooks(os.environ, Path.home())
    books = list(dict.fromkeys([*named, *([] if sketchbook else [default])]))

    def clean(book: Path) -> list[Path]:
        # Of an empty folder that no settings name only `install` can know.
        return remove(book, ("platform.txt", "boards.txt"), with_folder=book not in named)

    if not _in_each(books, "removed", clean):
        typer.echo(f"Nothing to do: nothing of hil is in {_listed(books)}.")


def _in_each(books: list[Path], done: str, do: Callable[[Path], list[Path]]) -> bool:
    """Change each sketchbook, and say what was changed; True if anything was. One that cannot be changed does
    not stop the others, and fails the command in the end."""
    from hil.arduino.install import InstallError

    changed, failure = False, None
    for book in books:
        try:
            paths = do(book)
        except InstallError as error:
            failure = fail(f"hil: {error}")
            continue
        changed = changed or bool(paths)
        for path in paths:
            typer.echo(f"{done} {path}")
    if failure:
        raise failure
    return changed


def _listed(books: list[Path]) -> str:
    return " and ".join(map(str, books))


def discovery(runtime_dir: RuntimeDir = None, ide_1_8: Ide18 = False) -> None:
    """The IDE's discovery: commands on standard input, JSON on standard output."""
    from hil.arduino.discovery import discover
    from hil.host.paths import runtime_bases

    with suppress(KeyboardInterrupt):
        bases = runtime_bases(runtime_dir, os.environ)
        discover(bases, 0, sys.stdout, is_named=runtime_dir is not None, for_1_8=ide_1_8)


def monitor() -> None:
    """The IDE's serial monitor: commands on standard input, JSON on standard output."""
    from hil.arduino.monitor import serve

    with suppress(KeyboardInterrupt):
        serve(0, sys.stdout)


def _program() -> Path:
    """Path of this installation's ``hil``: beside its Python, or else the one that was typed."""
    beside = Path(sys.executable).with_name("hil")
    return beside if beside.exists() else Path(shutil.which(sys.argv[0]) or sys.argv[0]).absolute()
