"""Lines and tables for people, on a terminal and elsewhere."""

import os
import re
import shutil
import sys
import textwrap
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import typer

from hil.vocab.shown_text import printable_lines

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult

_NOT_SHOWN = dict.fromkeys((7, 8, 11, 12, 13))
"""Control characters that rich leaves out."""
_HELD = "\0"
"""Space at which no line ends; texts that are shown have no such character."""
_LEAST_PROSE = 24
"""Characters of a line below which a column of sentences is not wrapped."""


def is_terminal() -> bool:
    """True if the standard output is a terminal, or is to be taken for one, as rich has it."""
    given = os.environ
    return sys.stdout.isatty() or bool(given.get("FORCE_COLOR")) or given.get("TTY_COMPATIBLE") == "1"


class Line(NamedTuple):
    """Text of one line or more, in parts: each with its style. ``wraps``: it is a sentence; it is wrapped at
    spaces, but not in a command between backquotes. It has one part or two."""

    parts: Sequence[tuple[str, str]]
    wraps: bool = False


class Grid(NamedTuple):
    """Table. ``texts``: columns that stand to the left; all others to the right. ``gap``: spaces between
    columns, 1 or 2. Where it is too wide for the terminal, columns of ``prose`` are wrapped at spaces, then
    columns stand below their rows with their names: those of ``later`` first, the last of all before others.
    So names stay whole. It has no head if no column has a name. ``notes``: lines below a row, by its number
    from 0; on a terminal they are wrapped at spaces."""

    columns: Sequence[str]
    texts: Collection[str]
    rows: Sequence[Sequence[str]]
    gap: int = 2
    prose: Collection[str] = ()
    later: Sequence[str] = ()
    notes: Mapping[int, Sequence[str]] = MappingProxyType({})


def line(text: str, style: str = "", *, wraps: bool = False) -> Line:
    """Make a line with one style."""
    return Line([(text, style)], wraps)


class ShownView:
    """Lines and tables, one below the other."""

    def __init__(self, *blocks: Line | Grid) -> None:
        self._blocks = blocks

    def __rich_console__(self, console: "Console", options: "ConsoleOptions") -> "RenderResult":
        from rich.text import Text

        width = min(options.max_width, terminal_columns() or options.max_width)
        for block in self._blocks:
            if isinstance(block, Line):
                if block.wraps:
                    (first, style), *_, (_, last) = [*block.parts, block.parts[-1]]
                    sentence = Text("\n".join(_lines(block, width)), last)
                    sentence.stylize(style, 0, len(first))
                    yield sentence
                else:
                    yield Text.assemble(*block.parts)
                continue
            head, rows = _table(block, width)
            yield from (Text(each, "bold", no_wrap=True, overflow="ignore") for each in head)
            yield from (Text(each, no_wrap=True, overflow="ignore") for each in rows)

    def __str__(self) -> str:
        """Text of it, as wide as it is."""
        return self._text(None)

    def text(self) -> str:
        """Text of it for the standard output: on a terminal not wider than that, where it can be."""
        return self._text(terminal_columns())

    def _text(self, width: int | None) -> str:
        return "\n".join(each for block in self._blocks for each in _lines(block, width))

    def print(self) -> None:
        """Print it, in lines that are whole to be copied. Elsewhere than on a terminal rich, which takes a
        fourth of a command's time to be imported, has nothing to add."""
        if is_terminal():
            from hil.cli.framework.consoles import long_lines

            long_lines().print(self)
        else:
            typer.echo(str(self))


def terminal_columns() -> int | None:
    """Width of the terminal; None: the standard output is none."""
    return shutil.get_terminal_size().columns if is_terminal() else None


def _lines(block: Line | Grid, width: int | None) -> list[str]:
    if isinstance(block, Line):
        lines = _split("".join(text for text, _ in block.parts))
        return [part for each in lines for part in _sentence(each, width)] if block.wraps and width else lines
    head, rows = _table(block, width)
    return [*head, *rows]


def _table(grid: Grid, width: int | None) -> tuple[list[str], list[str]]:
    """Lines of a table's head, and of its rows. ``width``: at most, where names stay whole; None: any."""
    columns = [_split(column) for column in grid.columns]
    rows = [[_split(cell) for cell in row] for row in grid.rows]
    shown = _Columns(grid, columns, rows, list(range(len(columns))), grid.gap)
    below = list[int]()
    if width is not None and shown.width > width:
        shown = shown.with_gap(1).wrapped(width)
        while shown.width > width and len(shown.kept) > 1:
            goes = next((i for name in grid.later for i in shown.kept if grid.columns[i] == name), 0)
            goes = goes or shown.kept[-1]
            below.append(goes)
            shown = shown.without(goes).wrapped(width)
    widths = shown.widths
    lines = [
        each
        for number, row in enumerate(shown.rows)
        for each in [
            *shown.lines(row, widths),
            *_below(grid, rows[number], sorted(below), width or 0),
            *_noted(grid.notes.get(number, ()), width),
        ]
    ]
    return shown.head(widths), lines


class _Columns(NamedTuple):
    """Columns of a table that stand beside each other. ``kept``: their numbers; all cells are in lines."""

    grid: Grid
    columns: list[list[str]]
    rows: list[list[list[str]]]
    kept: list[int]
    gap: int

    @property
    def widths(self) -> list[int]:
        cells = [self.columns, *self.rows]
        return [max(_width(part) for row in cells for part in row[i]) for i in self.kept]

    @property
    def width(self) -> int:
        return sum(self.widths) + self.gap * (len(self.kept) - 1) + 2

    def with_gap(self, gap: int) -> "_Columns":
        return self._replace(gap=gap)

    def without(self, column: int) -> "_Columns":
        return self._replace(kept=[i for i in self.kept if i != column])

    def wrapped(self, width: int) -> "_Columns":
        """Table whose columns of prose are wrapped, the last one first, so that it is that wide; as it is if
        that needs columns too narrow to be read."""
        made = self
        for column in reversed([i for i in self.kept if self.grid.columns[i] in self.grid.prose]):
            more = made.width - width
            own = made.widths[self.kept.index(column)]
            if more <= 0 or own - more < min(own, _LEAST_PROSE):
                continue
            head, *rows = [
                [
                    [part for line in cell for part in _wrapped(line, own - more)] if i == column else cell
                    for i, cell in enumerate(row)
                ]
                for row in (made.columns, *made.rows)
            ]
            made = made._replace(columns=head, rows=rows)
        return made

    def head(self, widths: list[int]) -> list[str]:
        if not any(self.grid.columns):
            return []
        height = max(len(self.columns[i]) for i in self.kept)
        return self.lines([[""] * (height - len(cell)) + cell for cell in self.columns], widths)

    def lines(self, row: list[list[str]], widths: list[int]) -> list[str]:
        is_left = [self.grid.columns[i] in self.grid.texts for i in self.kept]
        gap = " " * self.gap
        cells = [row[i] for i in self.kept]
        return [
            f" {gap.join(map(_padded, _at(cells, number), widths, is_left))} "
            for number in range(max(map(len, cells)))
        ]


def _below(grid: Grid, row: list[list[str]], columns: list[int], width: int) -> list[str]:
    """Lines with the cells of some columns, each behind its column's name, below a row."""
    lines = list[str]()
    for i in columns:
        if text := " ".join(row[i]).strip():
            name = " ".join(grid.columns[i].split())
            pair = f"{name}: {text}" if name else text
            if lines and _width(lines[-1]) + 2 + _width(pair) <= width:
                lines[-1] += f"  {pair}"
            elif grid.columns[i] in grid.prose:
                lines += [f"   {part}" for part in _wrapped(pair, max(width - 3, _LEAST_PROSE))]
            else:
                lines.append(f"   {pair}")
    return lines


def _noted(notes: Sequence[str], width: int | None) -> list[str]:
    lines = [part for each in notes for part in _split(each)]
    if width is None:
        return [f"   {each}" for each in lines]
    return [f"   {part}" for each in lines for part in _wrapped(each, max(width - 3, _LEAST_PROSE))]


def _sentence(text: str, width: int) -> list[str]:
    held = re.sub("`[^`]*`", lambda command: command[0].replace(" ", _HELD), text)
    return [part.replace(_HELD, " ") for part in _wrapped(held, width)]


def _wrapped(text: str, width: int) -> list[str]:
    indent = " " * (len(text) - len(text.lstrip(" ")))
    wrap = textwrap.TextWrapper(
        width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
    return wrap.wrap(text) or [""]


def _split(text: str) -> list[str]:
    return [part.expandtabs(8) for part in printable_lines(text.translate(_NOT_SHOWN)).split("\n")]


def _at(row: list[list[str]], index: int) -> list[str]:
    return [cell[index] if index < len(cell) else "" for cell in row]


def _width(text: str) -> int:
    if text.isascii() and text.isprintable():
        return len(text)
    from rich.cells import cell_len

    return cell_len(text)


def _padded(text: str, width: int, is_left: bool) -> str:
    room = " " * (width - _width(text))
    return text + room if is_left else room + text
