"""Files and drawings of an export, and what is said of them."""

import errno
import os
import shutil
import sys
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hil.recorded.exports.export_formats import ExportFormat
    from hil.recorded.recorded_fields import RunField
    from hil.recorded.recorded_run import RecordedRun
    from hil.telemetry.sampler import Interval
    from hil.vocab.time import SimTimeNs

_COUNTED = {"csv": "rows", "mcap": "messages", "vcd": "edges", "pcapng": "records"}


@contextmanager
def _opened(file: Path | None) -> "Iterator[BinaryIO]":
    """Open what is written into; None: the standard output. Raises Exit: it cannot be written."""
    from hil.host.new_file import new_file

    try:
        if file is None:
            yield sys.stdout.buffer
            sys.stdout.buffer.flush()
        else:
            with new_file(file) as out:
                yield out
    except BrokenPipeError:  # the reader has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(1) from None
    except OSError as error:
        name = "the standard output" if file is None else str(file)
        why = error.strerror or str(error)
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            left = "what is there is not whole" if file is None else "nothing of it was left"
            why = f"{why}; {left}. Take less with --from, --to and --every, or another disk"
        raise fail(f"hil: {name}: {why}") from None


def write_stream(
    ending: str,
    file: Path | None,
    write: Callable[[BinaryIO], int],
    what: str,
    from_ns: "SimTimeNs",
    to_ns: "SimTimeNs",
) -> CommandAnswer:
    """Write a file piece by piece, and say what is in it."""
    from hil.recorded.time_words import time_text

    with _opened(file) as out:
        count = write(out)
    window = f"{time_text(from_ns)} to {time_text(to_ns)}"
    answer = {"file": str(file or "-"), "format": ending, _COUNTED[ending]: count}
    answer |= {"from_ns": from_ns, "to_ns": to_ns}
    text = f"wrote {file}: {count:,} {_COUNTED[ending]} of {_short(what)}, {window}"
    if file is None:
        return CommandAnswer(answer)
    return CommandAnswer(answer, text)


_LONGEST = 200


def _short(what: str) -> str:
    return what if len(what) <= _LONGEST else f"{what[:_LONGEST].rsplit(', ', 1)[0]} and more"


def write_drawn(
    kind: "ExportFormat",
    file: Path | None,
    run: "RecordedRun",
    fields: "Sequence[RunField]",
    from_ns: "SimTimeNs",
    to_ns: "SimTimeNs",
    interval_ns: "Interval",
    told: Callable[[int], object],
) -> CommandAnswer:
    """Write a picture."""
    from hil.recorded.exports.drawn_export import recordings
    from hil.telemetry.picture import drawn

    found = recordings(run, fields, from_ns, to_ns, interval_ns, told)
    data = drawn(found, f".{kind.ending}", _title(run, fields))
    rows = sum(len(each.rows) for each in found.values())
    with _opened(file) as out:
        out.write(data)
    answer = {"file": str(file or "-"), "format": kind.ending, "samples": rows}
    text = f"wrote {file}: {rows:,} samples of {_short(', '.join(map(str, fields)))}"
    return CommandAnswer(answer, "" if file is None else text)


def draw_in_terminal(
    run: "RecordedRun",
    fields: "Sequence[RunField]",
    from_ns: "SimTimeNs",
    to_ns: "SimTimeNs",
    interval_ns: "Interval",
    told: Callable[[int], object],
) -> CommandAnswer:
    """Draw with characters."""
    from hil.cli.framework.problem_lines import has_colours
    from hil.recorded.exports.drawn_export import recordings
    from hil.telemetry import text_plot

    found = recordings(run, fields, from_ns, to_ns, interval_ns, told)
    width = min(shutil.get_terminal_size((80, 24)).columns, 160)
    colour = has_colours(sys.stdout)
    text = text_plot.draw(found, width, colour=colour, title=_title(run, fields))
    answer: dict[str, Any] = {
        axis: {"signals": ["at_ns", *each.signals], "rows": each.rows} for axis, each in found.items()
    }
    return CommandAnswer(answer, text, is_harmless=True)


def _title(run: "RecordedRun", fields: "Sequence[RunField]") -> str:
    from hil.vocab.shown_text import printable

    axes = dict.fromkeys(field.axis for field in fields)
    return printable(f"{run.runtime.name}: {_short(', '.join(axes))}")
