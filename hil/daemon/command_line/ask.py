"""Asking a running bench: what the commands that do so share."""

from pathlib import Path
from typing import Annotated, Any

import typer

RuntimeDir = Annotated[
    Path | None,
    typer.Option(
        "--runtime-dir",
        help="Folder of running benches' ports and sockets."
        " [default: $XDG_RUNTIME_DIR/hil; commands that ask look in /run/hil too]",
    ),
]
Bench = Annotated[
    str | None, typer.Option("--bench", "-b", help="The bench; needed when several are running.")
]
DeviceName = Annotated[
    str, typer.Argument(help="A device's name, as in the configuration.", show_default=False)
]


def fail(message: str, code: int = 1) -> typer.Exit:
    """What a command raises after it has said why."""
    import logging
    import os
    import sys

    from hil.daemon.service.journal import is_journal, prefixed, say

    in_journal = is_journal(sys.stderr, os.environ)
    say(prefixed(message, logging.ERROR) if in_journal else message, sys.stderr)
    return typer.Exit(code)


def sockets(runtime_dir: Path | None) -> list[Path]:
    """The control sockets of the benches that run here."""
    import os

    from hil.daemon.control.client import listener
    from hil.daemon.paths import control_sockets, runtime_bases

    def is_left_behind(path: Path) -> bool:
        try:
            return not listener(path)
        except OSError:
            return False  # `ask` says what is wrong with it

    found = [path for base in runtime_bases(runtime_dir, os.environ) for path in control_sockets(base)]
    return [path for path in found if not is_left_behind(path)]


def control_path(bench: str | None, runtime_dir: Path | None) -> Path:
    """The control socket of the bench that is meant; says what is wrong and ends the command."""
    paths = {path.parent.name: path for path in sockets(runtime_dir)}
    if bench is not None and bench not in paths:
        raise fail(f"hil: bench {bench!r} is not running here; running: {', '.join(paths) or 'none'}")
    if bench is None and len(paths) != 1:
        which = (
            f"several benches are running ({', '.join(paths)}): choose one with --bench"
            if paths
            else "no bench is running here"
        )
        raise fail(f"hil: {which}")
    return paths[bench] if bench else next(iter(paths.values()))


def ask_bench(bench: str | None, runtime_dir: Path | None, verb: str, **arguments: Any) -> Any:
    """One request to a bench; says what is wrong and ends the command where it fails."""
    from hil.daemon.control.client import ControlError, ask

    path = control_path(bench, runtime_dir)
    try:
        return ask(path, verb, **arguments)
    except ControlError as error:
        raise fail(f"hil: {error}") from None
