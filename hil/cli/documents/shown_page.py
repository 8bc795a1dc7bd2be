"""A page of Markdown on the terminal: laid out to its width, and paged where it is longer than the screen."""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator

from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.markdown import Markdown, TableElement
from rich.measure import Measurement
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from hil.cli.framework.consoles import ShownConsole
from hil.host.shown_stream import own

MOST_COLUMNS = 100
"""Width of lines beyond which text is hard to read."""
_IMAGE = re.compile(r"!\[([^\]]*)\]\([^)]*\)")
_BREAK = re.compile(r"<br ?/?>")
_LEAST_COLUMN = 14
"""Characters of a column below which its words are broken."""
_CODE_STYLE = "ansi_dark"
"""Colours of code that every terminal has."""


class _WholeTable(TableElement):
    """Table whose cells are folded, not cut: names in them are to be copied. One with too many columns for
    the terminal has its cells below each other, each behind its column's name."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for part in super().__rich_console__(console, options):
            if isinstance(part, Table):
                is_narrow = options.max_width < _LEAST_COLUMN * len(part.columns)
                if is_narrow and Measurement.get(console, options, part).maximum >= options.max_width:
                    yield from _below_each_other(part)
                    continue
                for column in part.columns:
                    column.overflow = "fold"
            yield part


def _below_each_other(table: Table) -> Iterator[RenderableType]:
    for cells in zip(*(column.cells for column in table.columns), strict=True):
        yield Text()
        for number, (column, cell) in enumerate(zip(table.columns, cells, strict=True)):
            name = Text.assemble(str(column.header), ": " if str(column.header) else "", style="dim")
            yield Padding(Text.assemble(name, cell, overflow="fold"), (0, 0, 0, 2 if number else 0))
    yield Text()


class _Page(Markdown):
    elements = {**Markdown.elements, "table_open": _WholeTable}  # noqa: RUF012 - as rich has it


def rendered(text: str, columns: int, *, colours: bool) -> str:
    """Lay a page out to a width. Links have their address behind them, pictures are their words."""
    text = _BREAK.sub("; ", _IMAGE.sub(r"*(picture: \1)*", text))
    console = ShownConsole(width=min(columns, MOST_COLUMNS), force_terminal=colours, no_color=not colours)
    page = _Page(text, code_theme=_CODE_STYLE, hyperlinks=False)
    with console.capture() as capture:
        console.print(page)
    return capture.get()


def show_page(text: str) -> None:
    """Show a page at the terminal of the standard output."""
    columns, rows = shutil.get_terminal_size()
    colours = not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    shown = rendered(text, columns, colours=colours)
    if shown.count("\n") < rows or not _paged(shown):
        own(sys.stdout).write(shown)


def _paged(text: str) -> bool:
    """Show a text in the user's pager; answers False if there is none."""
    words = shlex.split(os.environ.get("PAGER", "")) or ["less"]
    if os.path.basename(words[0]) == "less":
        words.append("-R")
    if shutil.which(words[0]) is None:
        return False
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the pager's
    try:
        subprocess.run(words, input=text.encode(errors="replace"), check=False)
    except OSError:
        return False
    finally:
        signal.signal(signal.SIGINT, before)
    return True
