"""Checks of cells that others name: as a factor, as a lock. A factor that leads back to itself is a loop."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from bridges.modbus.maps.map_part_rows import PartRow
from bridges.modbus.maps.map_parts_text import cell_part
from bridges.modbus.maps.map_row_models import CellText, PlaceText
from hil.config.document import Finding, KeyPath
from hil.config.explain import no_such

FACTORS = ("times", "per", "decimals", "to_rpm")
"""Keys of a row that may name a cell."""


def factor_findings(given: Mapping[Any, Any], rows: Sequence[PartRow]) -> Iterator[Finding]:
    """Findings of names of cells."""
    written = given.get("cells")
    names = {str(name) for name in written} if isinstance(written, dict) else set()
    cells = {row.name: row for row in rows if isinstance(row.text, CellText) and row.path[0] != "moves"}
    names |= cells.keys()
    moves = {f"move_{row.move}.{row.name}" for row in rows if row.path[0] == "moves"}
    for path, text in _texts(given, rows):
        yield from _name_findings(path, text, names | moves, cells)
    yield from _loop_findings(cells)
    yield from _locked_up_findings(cells)


def _texts(given: Mapping[Any, Any], rows: Sequence[PartRow]) -> Iterator[tuple[KeyPath, Any]]:
    for row in rows:
        if not row.move:
            yield row.path, row.text
    for key, value in given.items():
        if isinstance(value, dict) and key not in ("cells", "commands", "states", "mode", "blocks", "moves"):
            yield (key,), value


def _name_findings(
    path: KeyPath, text: PlaceText | Mapping[str, Any], names: set[str], cells: Mapping[str, PartRow]
) -> Iterator[Finding]:
    def value(key: str) -> Any:
        return text.get(key) if isinstance(text, Mapping) else getattr(text, key, None)

    for key in FACTORS:
        name = value(key)
        if not isinstance(name, str):
            continue
        if name not in names:
            wrong = no_such((*path, key), "cell", name, names)
            yield Finding(wrong.path, wrong.message, wrong.remedy)
        elif name in cells and (cells[name].text.type == "text" or cells[name].is_bit):
            what = f"{name} is {'a text' if cells[name].text.type == 'text' else 'a bit'}, and no factor"
            yield Finding((*path, key), what, "name a cell with a number")
    lock = value("locked_by")
    cell = getattr(lock, "cell", None)
    if cell is not None and cell not in names:
        wrong = no_such((*path, "locked_by", "cell"), "cell", cell, names)
        yield Finding(wrong.path, wrong.message, wrong.remedy)
    elif cell is not None and cell == path[-1]:
        what = f"{cell} is locked by itself"
        yield Finding((*path, "locked_by", "cell"), what, "name another cell, which unlocks it")
    elif lock is not None and cell is not None and cell in cells:
        yield from _lock_findings((*path, "locked_by", "value"), lock.value, cells[cell])


def _lock_findings(path: KeyPath, value: float, cell: PartRow) -> Iterator[Finding]:
    """Findings of a lock whose cell never has the value that opens it."""
    place = cell.place
    if place is None or cell.text.type == "text":
        return
    part = cell_part(cell.text, place)
    if part.default == value:
        return
    is_plain = not place.is_bit and (place.conversion is None or not place.conversion.names)
    if not part.is_written:
        yield Finding(path, f"{cell.name} is {part.default:g} for good, and never {value:g}", "write another")
    elif not part.lowest <= value <= part.highest or (is_plain and not place.holds(value)):
        yield Finding(path, f"{cell.name} never is {value:g}", "write a value that it takes")


def _locked_up_findings(cells: Mapping[str, PartRow]) -> Iterator[Finding]:
    """Findings of cells that lock each other: none of them can be unlocked first."""
    locks = {name: lock for name, row in cells.items() if (lock := row.text.locked_by) is not None}
    told: set[str] = set()
    for first in locks:
        trail = [first]
        while (following := locks.get(trail[-1])) is not None and following.cell not in trail:
            trail.append(following.cell)
        if following is None or following.cell != first or len(trail) == 1 or told & set(trail):
            continue
        told |= set(trail)
        what = f"a loop of locks: {' by '.join([*trail, first])}"
        yield Finding((*cells[first].path, "locked_by", "cell"), what, "let one of them be free")


def _loop_findings(cells: Mapping[str, PartRow]) -> Iterator[Finding]:
    """One finding for each loop, at the first of its cells."""
    named = {
        name: {other: key for key in FACTORS if isinstance(other := getattr(row.text, key), str)}
        for name, row in cells.items()
    }
    told: set[str] = set()
    for first in cells:
        trail = _way_back(first, named)
        if trail and not told & set(trail):
            told |= set(trail)
            what = f"a loop of scales: {' by '.join([*trail, first])}"
            key = named[first][trail[1] if len(trail) > 1 else first]
            yield Finding((*cells[first].path, key), what, "let one of them have a number")


def _way_back(first: str, named: Mapping[str, Mapping[str, str]]) -> list[str]:
    """Shortest way from a cell by its factors back to it; empty: there is none."""
    before, waiting = {first: ""}, [first]
    for here in waiting:
        for other in named.get(here, ()):
            if other == first:
                trail = [here]
                while trail[0] != first:
                    trail.insert(0, before[trail[0]])
                return trail
            if other not in before:
                before[other] = here
                waiting.append(other)
    return []
