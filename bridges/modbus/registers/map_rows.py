"""A register map in rows, for the control socket, and its formats: table, CSV, Markdown and JSON."""

import json
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from bridges.modbus.registers.registers_protocol import UnitMap

COLUMNS = ("table", "address", "registers", "type", "access", "name", "unit", "about")
FORMATS = ("table", "csv", "markdown", "json")


def map_rows(of: UnitMap) -> dict[str, Any]:
    """Rows of a map, in the order of tables and addresses."""
    rows = [
        {
            "table": cell.table.name.lower(),
            "address": cell.address,
            "registers": cell.width,
            "type": cell.type,
            "name": cell.name,
            "unit": cell.unit,
            "about": cell.about,
            "is_writable": cell.is_writable,
        }
        for cell in of.cells
    ]
    head = {"device": of.info.name, "profile": of.info.profile, "version": of.version, "crc": of.crc}
    return {**head, "notes": list(of.notes), "rows": rows}


def formatted(answer: Mapping[str, Any], form: str, width: int | None = None) -> Iterator[str]:
    """Write a map as lines. ``form``: one of ``FORMATS``. ``width``: of the terminal; where a table has no
    room in it, each register has lines of its own. None: any."""
    if form == "json":
        yield json.dumps(answer, indent=1)
        return
    cells = [_cells(row) for row in answer["rows"]]
    if form == "csv":
        yield ",".join(COLUMNS)
        yield from (",".join(map(_quoted, row)) for row in cells)
        return
    if form == "markdown":
        yield f"| {' | '.join(COLUMNS)} |"
        yield f"|{'---|' * len(COLUMNS)}"
        yield from (f"| {' | '.join(text.replace('|', chr(92) + '|') for text in row)} |" for row in cells)
        return
    of = f"{answer['device']}, a {answer['profile']}"
    yield from wrapped(f"{of}: map version {answer['version']}, CRC {answer['crc']:08x}", width)
    table = list(_table([COLUMNS, *cells]))
    if width is None or max(map(len, table)) <= width:
        yield from table
    else:
        for row in answer["rows"]:
            yield from _own_lines(row, width)
    for note in answer["notes"]:
        yield from wrapped(f"note: {note}", width)


def wrapped(text: str, width: int | None, indent: str = "") -> list[str]:
    """Lines of a text, at spaces. ``width``: characters, at most, where words stay whole; None: one line."""
    if width is None:
        return [indent + text]
    made = textwrap.TextWrapper(width, initial_indent=indent, subsequent_indent=indent)
    made.break_long_words = made.break_on_hyphens = False
    return made.wrap(text)


def _own_lines(row: Mapping[str, Any], width: int) -> Iterator[str]:
    """Lines of one register for a terminal in which a table has no room."""
    yield f"{row['table']} {row['address']}"
    access = "rw" if row["is_writable"] else "r"
    count = f"{row['registers']} register{'s' if row['registers'] > 1 else ''}"
    yield f"  {row['name']}"
    for text in (", ".join(filter(None, (count, row["type"], access, row["unit"]))), row["about"]):
        yield from wrapped(" ".join(text.split()), width, "  ")


def register_maps(answers: Mapping[str, Mapping[str, Any]]) -> str:
    """Write the part of the reference with the maps of boards. ``answers``: of ``map_rows``, by profile."""
    parts = [
        "## Register maps\n",
        "Of boards with one axis, of a drive the map that is built in; `hil modbus map` prints that of any"
        " device.\n",
    ]
    for profile, answer in answers.items():
        parts.append("\n".join([f"### Registers of `{profile}`\n", *formatted(answer, "markdown"), ""]))
    return "\n".join(parts)


def _cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    shown = {**row, "access": "rw" if row["is_writable"] else "r"}
    return tuple(" ".join(str(shown[column]).split()) for column in COLUMNS)


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n') else text


def _table(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)][:-1]
    for row in rows:
        yield "  ".join([*(text.ljust(width) for text, width in zip(row, widths, strict=False)), row[-1]])
