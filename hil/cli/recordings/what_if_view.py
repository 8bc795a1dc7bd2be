"""Options of ``hil replay`` that change a run, and what is told of the changed one."""

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.problem_lines import has_colours
from hil.cli.framework.progress_bars import bar
from hil.cli.framework.shown_words import counted, shown_number
from hil.cli.recordings.opened import opened, time_of

if TYPE_CHECKING:
    from hil.recorded.log_changes import LogChanges
    from hil.recorded.parting import HeardPiece, RunsApart
    from hil.recorded.recorded_run import RecordedRun
    from hil.recorded.what_if import RunSeries
    from hil.recorded.what_if import WhatIf as AskedWhatIf

_MOST_FIELDS = 8
"""Maximum number of fields that are told of the first difference."""
_POINTS = 2000
"""Samples of a drawing over its window."""


class WhatIfOptions(NamedTuple):
    """Options that change a run."""

    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help="Run it with this changed: a field as m1.pKp=10, a key of the configuration as"
            " m1.axis.inertia_kg_m2=0.0001 or bus0.baud=9600, or seed=7. May be given several times.",
            metavar="NAME=VALUE",
        ),
    ] = None
    at: Annotated[
        str | None,
        typer.Option("--at", help="When fields are set. [default: from the start]", metavar="TIME"),
    ] = None
    faults: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            help="Run it with this fault, as 'byte_drop m1 rate=0.5 at=12.5s for=1s'.",
            metavar="FAULT",
        ),
    ] = None
    without: Annotated[
        list[str] | None,
        typer.Option(
            "--no-fault", help="Run it without a fault: its number, its kind, or all.", metavar="FAULT"
        ),
    ] = None
    fields: Annotated[
        list[str] | None,
        typer.Option(
            "--field",
            help="Draw this field of both runs, as m1.e. [default: those that part]",
            metavar="FIELD",
        ),
    ] = None
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Write both runs and their difference as a picture (.png, .svg, .pdf) instead of drawing in"
            " the terminal.",
            show_default=False,
        ),
    ] = None

    @property
    def is_given(self) -> bool:
        """True if something is changed."""
        return bool(self.settings or self.faults or self.without)


def changes_of(options: WhatIfOptions, run: "RecordedRun") -> "LogChanges":
    """Changes that options ask for. Raises Exit with 2: there cannot be such."""
    from hil.recorded.log_changes import ChangeRefused, changed
    from hil.recorded.time_words import NoSuchTime

    at_ns = None if options.at is None else time_of("--at", options.at, run)
    try:
        return changed(run, options.settings or (), options.faults or (), options.without or (), at_ns)
    except (ChangeRefused, NoSuchTime) as error:
        raise fail(f"hil: {error}", 2) from None


def what_if(log: Path, options: WhatIfOptions, since: str | None, to: str | None) -> CommandAnswer:
    """Run a recording with something changed, and tell where the runs part. Raises Exit with 2: it cannot
    be changed so."""
    from hil.config import ConfigError
    from hil.recorded.log_changes import ChangeRefused
    from hil.recorded.recorded_fields import NoSuchField, parse_fields
    from hil.recorded.what_if import WhatIf, told_fields
    from hil.vocab.time import SimTimeNs

    with opened(log) as run:
        from_ns = None if since is None else time_of("--from", since, run)
        to_ns = run.end_ns if to is None else time_of("--to", to, run)
        asked = WhatIf(run.log, changes_of(options, run))
        try:
            fields = parse_fields(run.runtime, options.fields or ())
            asked.now().close()  # what is wrong with the changed bench is known before the long part
        except NoSuchField as error:
            raise fail(f"hil: {error}", 2) from None
        except ConfigError as error:
            said = str(error).replace("<dict>: ", "")
            raise fail(f"hil: the changed configuration is refused:\n{said}", 2) from None
        try:
            with bar(f"{log.name} runs again, also changed"):
                found = asked.parting()
        except ChangeRefused as error:
            raise fail(f"hil: {error}", 2) from None
        first_ns = found.first_ns
        fields = fields or [*told_fields(run, found)]
        series = {}
        if fields and (first_ns is not None or options.fields):
            start_ns = from_ns if from_ns is not None else first_ns or SimTimeNs(0)
            if start_ns >= to_ns:
                start_ns = SimTimeNs(0)
            with bar(f"{log.name} is drawn"):
                series = asked.series(fields, start_ns, to_ns, max((to_ns - start_ns) // _POINTS, 1000))
    values = {"identical": first_ns is None, **_values(asked, found), "series": _columns(series)}
    text = "\n".join(_lines(asked, found))
    return CommandAnswer(values, "\n".join([text, *_drawn(series, options.output, log)]), is_harmless=True)


def _values(asked: "AskedWhatIf", found: "RunsApart") -> dict[str, Any]:
    def piece(of: "HeardPiece | None") -> dict[str, Any] | None:
        return of and {"at_ns": of.at_ns, "hex": of.data.hex()}

    return {
        "parts_at_ns": found.first_ns,
        "state_at_ns": found.at_ns,
        "fields": [each._asdict() for each in found.fields],
        "sent": [{"place": e.place, "then": piece(e.then), "now": piece(e.now)} for e in found.sent],
        "left_out": [{"input": asked.changes.log.where(i), "why": why} for i, why in asked.left_out.items()],
    }


def _columns(series: "dict[str, RunSeries]") -> dict[str, Any]:
    return {name: {"signals": ["at_ns", *each.signals], "rows": each.rows} for name, each in series.items()}


def _lines(asked: "AskedWhatIf", found: "RunsApart") -> "list[str]":
    from hil.recorded.time_words import time_text

    left_out = [f"  {asked.changes.log.where(i)}: {why}" for i, why in asked.left_out.items()]
    told = left_out and [
        f"{counted(len(left_out), 'input')} of the log left out, which the changed bench cannot take:",
        *left_out[:_MOST_FIELDS],
        *(["  ..."] if len(left_out) > _MOST_FIELDS else []),
    ]
    if found.first_ns is None:
        return ["identical: the change makes no difference to any byte, time or state", *told]
    lines = [f"the runs part at {time_text(found.first_ns)}"]
    if found.at_ns is not None:
        lines.append(f"states at {time_text(found.at_ns)}:")
        lines += [
            f"  {each.axis}.{each.name}  then {shown_number(each.then)}, now {shown_number(each.now)}"
            for each in found.fields[:_MOST_FIELDS]
        ]
        if len(found.fields) > _MOST_FIELDS:
            lines.append(f"  and {len(found.fields) - _MOST_FIELDS} more fields")
    if found.sent:
        lines.append("bytes sent:")
        for each in found.sent[:_MOST_FIELDS]:
            lines.append(
                f"  {each.place}  then {_said(each.then, each.now)}, now {_said(each.now, each.then)}"
            )
    return [*lines, *told]


def _said(piece: "HeardPiece | None", other: "HeardPiece | None") -> str:
    """Words of a piece: its bytes around the first that differs from the other's."""
    from hil.recorded.run_events import bytes_words
    from hil.recorded.time_words import time_text

    if piece is None:
        return "nothing"
    pairs = zip(piece.data, other.data if other else b"", strict=False)
    same = next((i for i, (byte, others) in enumerate(pairs) if byte != others), 0)
    return f"{bytes_words(piece.data[max(same - 20, 0) : same + 40])} at {time_text(piece.at_ns)}"


def _drawn(series: "dict[str, RunSeries]", output: Path | None, log: Path) -> "list[str]":
    if not series:
        return [f"nothing to draw: {output} was not written"] if output else []
    if output is None:
        from hil.telemetry.text_plot import draw

        width = shutil.get_terminal_size().columns
        return ["", draw({**series}, min(width, 100), colour=has_colours(sys.stdout))]
    from hil.telemetry.picture import PictureError
    from hil.telemetry.picture import draw as draw_picture

    try:
        draw_picture({**series}, output, f"{log.name}: then and now")
    except PictureError as error:
        raise fail(f"hil: {error}", 2) from None
    return [f"{output} written"]
