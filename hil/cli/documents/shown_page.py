"""A page of Markdown on the terminal: laid out to its width, and paged where it is longer than the screen."""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys

from rich.console import Console, ConsoleOptions, RenderResult
from rich.markdown import Markdown, TableElement
from rich.table import Table

from hil.cli.framework.consoles import ShownConsole
from hil.host.shown_stream import own

MOST_COLUMNS = 100
"""Width of lines beyond which text is hard to read."""
_IMAGE = re.compile(r"!\[([^\]]*)\]\([^)]*\)")
_BREAK = re.compile(r"<br ?/?>")
_CODE_STYLE = "ansi_dark"
"""Colours of code that every terminal has."""


class _WholeTable(TableElement):
    """Table whose cells are folded, not cut: names in them are to be copied."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for part in super().__rich_console__(console, options):
            if isinstance(part, Table):
                for column in part.columns:
                    column.overflow = "fold"
            yield part


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
