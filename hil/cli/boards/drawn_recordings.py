"""Drawings of recordings: in the terminal, as a picture, or the numbers as a table."""

import os
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.problem_lines import has_colours
from hil.vocab.shown_text import printable, printable_lines

Output = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        help="Write a picture (.png, .svg, .pdf) or the numbers (.csv) instead of drawing in the terminal.",
        show_default=False,
    ),
]


def check_output(output: Path | None) -> None:
    """Check, before anything moves or is recorded, that a file can be written."""
    from hil.telemetry import picture

    if output is None:
        return
    suffix = output.suffix.lower()
    if suffix not in (*picture.FORMATS, ".csv"):
        what = f"{suffix!r} is the ending of no picture" if suffix else "it has no ending"
        raise fail(f"{output}: {what}; write a name that ends in {', '.join(picture.FORMATS)} or .csv", 2)
    if not output.parent.is_dir():
        raise fail(f"{output}: there is no folder {output.parent}", 2)
    if not os.access(output.parent, os.W_OK):
        raise fail(f"{output}: the folder {output.parent} cannot be written to", 2)
    if suffix in picture.FORMATS:
        try:
            picture.check_can_draw()
        except picture.PictureError as error:
            raise fail(f"hil: {error}", 2) from None


def shown_recording(
    recording: Any, output: Path | None, title: str, notes: str = "", drawn_until_ns: float | None = None
) -> str:
    """Draw a recording, up to a time; answers the drawing, or what was written where, with the notes. Numbers
    are written of all of it."""
    from hil.host.new_file import write_file
    from hil.telemetry import picture, text_plot

    if not recording.rows:
        raise fail("hil: no sample came")
    seen = recording
    if drawn_until_ns is not None:
        seen = replace(recording, rows=[row for row in recording.rows if row[0] <= drawn_until_ns])
    if output:
        suffix = output.suffix.lower()
        try:
            if suffix == ".csv":
                data = "".join(recording.csv()).encode()
            else:
                sampling = "" if recording.sampling in notes else recording.sampling
                told = "; ".join(filter(None, (notes, sampling)))
                data = picture.drawn({"": seen}, suffix, title, told)
            write_file(output, data)
        except picture.PictureError as error:
            raise fail(f"hil: {error}") from None
        except OSError as error:
            raise fail(f"hil: {output}: {error.strerror}") from None
        said = (
            f"wrote {printable(str(output))}: {len(recording.rows)} samples of {', '.join(recording.signals)}"
        )
    else:
        width = min(shutil.get_terminal_size((80, 24)).columns, 160)
        colour = has_colours(sys.stdout)
        said = text_plot.draw({"": seen}, width, colour=colour, title=printable(title))
    return f"{said}\n{printable_lines(notes)}" if notes else said
