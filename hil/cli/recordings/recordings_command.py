"""The command that lists recordings."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import AsJson

if TYPE_CHECKING:
    from hil.recorded.recordings_list import ListedRecording


def recordings(
    bench: Annotated[
        str | None,
        typer.Option("--bench", help="Only those of this bench.", metavar="NAME", show_default=False),
    ] = None,
    state_dir: Annotated[
        Path | None,
        typer.Option("--state-dir", help="Folder of benches' state. [default: yours and that of services]"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the recordings of benches, the latest last.

    Every run of `hil serve` is recorded. Other commands take a name from this list in place of a path, or its
    beginning; `last` is the latest, `last-1` the one before, `lab/last` the latest of a bench.

    Example: hil recordings
    """
    import os

    from hil.host.paths import state_bases
    from hil.recorded.recording_names import recordings_of
    from hil.recorded.recordings_list import listed_recordings

    bases = state_bases(state_dir, os.environ)
    found, where = listed_recordings(recordings_of(bases, bench)), " and ".join(map(str, bases))
    if bench is not None and not found:
        raise fail(f"hil: no recordings of {bench} in {where}; `hil recordings` lists all")
    if as_json:
        typer.echo(json.dumps([each.as_dict() for each in found]))
    elif not found:
        typer.echo(f"no recordings in {where}")
    else:
        _show(found)


def _show(found: "list[ListedRecording]") -> None:
    from hil.cli.framework.shown_view import Grid, ShownView, line
    from hil.recorded.time_words import time_text

    rows = []
    for each in found:
        summary, told = each.summary, each.as_dict()
        begun = each.begun.astimezone().strftime("%Y-%m-%d %H:%M:%S %Z") if each.begun else ""
        inputs = "" if summary.inputs is None else str(summary.inputs)
        end = f"{each.end}: {each.hung}" if each.hung else each.end
        length = time_text(summary.end_ns // 1_000_000 * 1_000_000)
        rows.append((told["name"], begun, length, end, _faults(summary.faults), inputs, _size(summary.size)))
    columns = ("recording", "begun", "simulated", "end", "faults", "inputs", "size")
    folders = sorted({str(each.summary.path.parent) for each in found})
    shown = Grid(
        columns, ("recording", "begun", "end", "faults"), rows, later=("inputs", "faults", "begun", "size")
    )
    ShownView(shown, line(""), *(line(f"in {folder}") for folder in folders)).print()


def _faults(faults: Mapping[str, int] | None) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in (faults or {}).items())


def _size(size: int) -> str:
    return f"{size / 1e6:.1f} MB" if size >= 1e6 else f"{size / 1e3:.1f} kB"
