"""Lines and tables for people, on a terminal and elsewhere."""

import os
import sys
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, NamedTuple

import typer

from hil.vocab.shown_text import printable_lines

if TYPE_CHECKING:
    from rich.console import RenderableType

_NOT_SHOWN = dict.fromkeys((7, 8, 11, 12, 13))
"""Control characters that rich leaves out."""


def is_terminal() -> bool:
    """True if the standard output is a terminal, or is to be taken for one, as rich has it."""
    given = os.environ
    return sys.stdout.isatty() or bool(given.get("FORCE_COLOR")) or given.get("TTY_COMPATIBLE") == "1"


class Line(NamedTuple):
    """Text of one line or more, in parts: each with its style."""

    parts: Sequence[tuple[str, str]]


class Grid(NamedTuple):
    """Table. ``texts``: columns that stand to the left; all others to the right. ``folds``: cells are folded
    where the terminal is too narrow. ``gap``: spaces between columns, 1 or 2."""

    columns: Sequence[str]
    texts: Collection[str]
    rows: Sequence[Sequence[str]]
    folds: bool = True
    gap: int = 2


def line(text: str, style: str = "") -> Line:
    """Make a line with one style."""
    return Line([(text, style)])


class ShownView:
    """Lines and tables, one below the other."""

    def __init__(self, *blocks: Line | Grid) -> None:
        self._blocks = blocks

    def __rich__(self) -> "RenderableType":
        from rich.console import Group
        from rich.table import Table
        from rich.text import Text

        def rich_block(block: Line | Grid) -> "RenderableType":
            if isinstance(block, Line):
                return Text.assemble(*block.parts)
            table = Table(box=None, collapse_padding=block.gap == 1)
            for column in block.columns:
                is_text = column in block.texts
                table.add_column(
                    column,
                    justify="left" if is_text else "right",
                    overflow="fold" if block.folds else "ellipsis",
                )
            for row in block.rows:
                table.add_row(*map(Text, row))
            return table

        return Group(*map(rich_block, self._blocks))

    def __str__(self) -> str:
        """The text that rich makes of it where no terminal is."""
        return "\n".join(each for block in self._blocks for each in _lines(block))

    def print(self) -> None:
        """Print it, in lines that are whole to be copied. Elsewhere than on a terminal rich, which takes a
        fourth of a command's time to be imported, has nothing to add."""
        if is_terminal():
            from hil.cli.framework.consoles import long_lines

            long_lines().print(self)
        else:
            typer.echo(str(self))


def _lines(block: Line | Grid) -> list[str]:
    if isinstance(block, Line):
        return _split("".join(text for text, _ in block.parts))
    head, *rows = [[_split(cell) for cell in row] for row in (block.columns, *block.rows)]
    height = max(map(len, head))
    table = [[[""] * (height - len(cell)) + cell for cell in head], *rows]
    widths = [max(_width(part) for row in table for part in row[i]) for i in range(len(head))]
    is_left = [column in block.texts for column in block.columns]
    return [
        f" {(' ' * block.gap).join(map(_padded, _at(row, i), widths, is_left))} "
        for row in table
        for i in range(max(map(len, row)))
    ]


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
