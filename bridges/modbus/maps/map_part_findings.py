"""Checks of what version 2 of a map has: rows of its parts, and what they say of each other."""

from collections.abc import Collection, Iterator, Mapping, MutableMapping
from math import inf
from typing import Any

from bridges.modbus.maps.command_findings import command_findings, state_findings
from bridges.modbus.maps.drive_map_model import NEW_PARTS
from bridges.modbus.maps.factor_findings import factor_findings
from bridges.modbus.maps.map_part_rows import MOVE_NAMES, PartRow, blocks_of, part_rows
from bridges.modbus.maps.map_parts_text import READ_ONLY, cell_part
from bridges.modbus.maps.map_places import is_new, place_findings
from bridges.modbus.maps.map_row_models import (
    TABLES,
    ByValueText,
    CellText,
    ModeText,
    PlaceText,
    StateRowText,
)
from bridges.modbus.protocol.pdu import ADDRESSES, Table
from bridges.modbus.registers.cells import REGISTERS
from bridges.modbus.registers.drive_map import RegisterPlace
from bridges.modbus.registers.map_parts import CAUSES
from hil.config.document import Finding, KeyPath
from hil.config.explain import no_such
from hil.vocab.drive_words import MORE_TAKEN, MORE_TOLD, TAKEN, TOLD

MOVE_MARK = "move "
_READERS = {Table.HOLDING_REGISTERS: 3, Table.INPUT_REGISTERS: 4, Table.COILS: 1, Table.DISCRETE_INPUTS: 2}
_WRITERS = {
    (Table.COILS, False): (5, 15),
    (Table.HOLDING_REGISTERS, False): (6, 16, 22, 23),
    (Table.HOLDING_REGISTERS, True): (16, 23),
}
"""Functions that write, by the table, and by whether it is more than one register at once."""
_COMMANDED = ("control", "commands", "mode", "moves", "parameters")
"""Keys of what a master writes, beside the values that a drive takes. Cells may be there to be read alone."""


def version_findings(given: object, entries: Mapping[KeyPath, PlaceText]) -> Iterator[Finding]:
    """Findings of keys that a map of version 1 has not."""
    remedy = "write modbus_map: 2"
    for key in given if isinstance(given, dict) else ():
        if key in NEW_PARTS or key in MORE_TOLD or key in MORE_TAKEN:
            yield Finding((key,), f"version 1 of a map has no {key}", remedy, at_key=True)
    for path, entry in entries.items():
        for key in is_new(entry) if path[0] not in MORE_TOLD and path[0] not in MORE_TAKEN else ():
            what = f"type {entry.type}" if key == "type" else key
            yield Finding((*path, key), f"version 1 of a map has no {what}", remedy)


def axis_findings(given: object, parameters: Collection[str] | None) -> Iterator[Finding]:
    """Findings of a map at a board with an axis that it does not move, or the other way round."""
    if parameters is None or not isinstance(given, dict):
        return
    known = (*TOLD, *TAKEN, *MORE_TOLD, *MORE_TAKEN, "control", "moves", "mode")
    of_axis = [key for key in given if key in known and given[key] is not None]  # a log has null for the rest
    if not parameters:
        for key in of_axis:
            yield Finding((key,), "this board has no axis", "write a plain cell, below cells", at_key=True)
    elif not of_axis and not blocks_of(given):
        what = "nothing here is of a motor, which this board has"
        yield Finding((), what, "write where it is told to move, or take profile: modbus_meter")


def end_findings(path: KeyPath, text: PlaceText, table: str, *, is_bit: bool) -> Iterator[Finding]:
    """Findings of a value that ends behind its table."""
    address = getattr(text, table)
    width = 1 if is_bit else REGISTERS[text.type] * (text.registers or 1)
    if address + width > ADDRESSES:
        count = "two" if width == 2 else width
        what = f"{text.type} takes {count} registers, and behind {ADDRESSES - 1} there is none"
        if width == 2:
            what = f"{text.type} takes two registers, and behind {address} there is none"
        yield Finding((*path, table), what, f"write {ADDRESSES - width} or less")


def part_findings(given: object, places: MutableMapping[KeyPath, RegisterPlace]) -> Iterator[Finding]:
    """Findings of a map of version 2 beside those of its values and bits. ``places``: gets the places of its
    rows, to find those that overlap."""
    if not isinstance(given, dict):
        return
    rows = list(part_rows(given))
    for row in rows:
        wrong = list(_row_findings(row)) if not row.move else []
        yield from wrong
        if not wrong and (place := row.place) is not None and place.address & 0xFFFF < ADDRESSES:
            path = (*row.path, f"{MOVE_MARK}{row.move}") if row.move else row.path
            places[path] = place
    yield from _block_findings(given, places)
    yield from factor_findings(given, rows)
    yield from command_findings(given, rows)
    yield from _protocol_findings(given, places)
    yield from _reserved_findings(given)


def _reserved_findings(given: Mapping[Any, Any]) -> Iterator[Finding]:
    """Findings of reserved registers: one table, and none behind its end."""
    reserved = given.get("reserved")
    for at, each in enumerate(reserved if isinstance(reserved, list | tuple) else ()):
        if not isinstance(each, dict):
            continue
        path: KeyPath = ("reserved", at)
        tables = [word for word in ("input", "holding") if each.get(word) is not None]
        if len(tables) != 1:
            what = f"{' and '.join(tables)} are both given" if tables else "no table is given"
            yield Finding(path, f"{what}; an entry is in one table", "write input or holding")
            continue
        first, count = each[tables[0]], each.get("registers", 1)
        if isinstance(first, int) and isinstance(count, int) and first < ADDRESSES < first + count:
            what = f"behind {ADDRESSES - 1} there is no register"
            yield Finding((*path, "registers"), what, f"write {ADDRESSES - first} or less")


def _row_findings(row: PartRow) -> Iterator[Finding]:
    path, text = row.path, row.text
    tables = text.tables
    if row.block is None:
        allowed = _allowed(row)
        remedy = f"write {' or '.join(allowed)}, as in {{{allowed[0]}: 0}}"
        if len(tables) != 1:
            what = f"{' and '.join(tables)} are both given" if tables else "no table is given"
            yield Finding(path, f"{what}; an entry is in one table", remedy)
            return
        if tables[0] not in allowed:
            what = f"{row.name} is written by the client" if tables[0] in ("input", "discrete") else (
                f"{row.name} is a number, which takes registers"
            )  # fmt: skip
            yield Finding((*path, tables[0]), what, remedy, at_key=True)
            return
        yield from end_findings(path, text, tables[0], is_bit=row.is_bit)
        if tables[0] in ("discrete", "coil") and text.bit is not None:
            yield Finding((*path, "bit"), f"a {tables[0]} is a single bit already", "remove it", at_key=True)
    else:
        for table in tables:
            yield Finding((*path, table), "a row of a block has its register there", "write at: 0", True)
        width = 1 if row.is_bit else REGISTERS[text.type] * (text.registers or 1)
        if text.at + width > row.block.registers:
            what = (
                f"it ends with register {text.at + width - 1}, and the block with {row.block.registers - 1}"
            )
            yield Finding((*path, "at"), what, "write one that fits, or give the block more registers")
        if row.kind == "value":
            yield from _value_findings(row)
    yield from place_findings(path, text, is_bit=row.is_bit, quantity=row.quantity)
    if "on_write" in text.model_fields_set and text.on_write:
        yield Finding((*path, "on_write"), f"{row.name} is no bit of control", "remove it", at_key=True)
    if row.path[:2] == ("moves", "cells") and row.name in MOVE_NAMES:
        what = f"{row.name} is a column of moves already"
        yield Finding(path, what, "write it beside cells, or give it another name", at_key=True)
    if isinstance(text, CellText):
        yield from _cell_findings(row, text)
    elif isinstance(text, StateRowText):
        yield from state_findings(row, text)


def _value_findings(row: PartRow) -> Iterator[Finding]:
    known = {**TOLD, **TAKEN, **MORE_TOLD, **MORE_TAKEN}
    assert row.block is not None
    if row.name not in known:
        wrong = no_such(row.path, "value", row.name, known)
        yield Finding(row.path, wrong.message, wrong.remedy, at_key=True)
    elif row.block.table is Table.INPUT_REGISTERS and (row.name in TAKEN or row.name in MORE_TAKEN):
        what = f"{row.name} is written by the client, and the block has input registers"
        yield Finding(row.path, what, "put it into a block of holding registers", at_key=True)
    if row.text.bit is not None:
        yield Finding((*row.path, "bit"), f"{row.name} is a value and no bit", "remove it", at_key=True)


def _allowed(row: PartRow) -> list[str]:
    if isinstance(row.text, StateRowText):
        return ["input", "holding"]
    if isinstance(row.text, ByValueText | ModeText):
        return ["holding", "coil"] if isinstance(row.text, ByValueText) else ["holding"]
    return ["holding"] if row.path[0] == "moves" else list(TABLES)


def _cell_findings(row: PartRow, text: CellText) -> Iterator[Finding]:
    path = row.path
    place = row.place
    if place is None:
        return
    if text.access is not None and "w" in text.access and place.table in READ_ONLY:
        yield Finding((*path, "access"), "a master writes no such table", "write r, or take holding or coil")
    if isinstance(text.value, str):
        if text.type != "text":
            yield Finding((*path, "value"), f"a {text.type} has a number", "write one, or type: text")
        elif len(text.value) > 2 * place.count or not text.value.isascii():
            what = f"{place.count} registers have {2 * place.count} characters of ASCII"
            yield Finding((*path, "value"), what, "write a shorter text, or more registers")
        return
    low = -inf if text.minimum is None else text.minimum
    high = inf if text.maximum is None else text.maximum
    if low > high:
        yield Finding((*path, "minimum"), f"{low:g} is above the maximum, {high:g}", "write less")
        return
    for key in ("value", "minimum", "maximum"):
        number = getattr(text, key)
        if number is None or place.is_bit or text.type == "text":
            continue
        is_plain = place.conversion is None or not place.conversion.names
        if is_plain and not place.holds(number):
            what = f"a {text.type} with a scale of {text.scale:g} cannot hold {number:g}"
            yield Finding((*path, key), what, "write another value, type or scale")
    part = cell_part(text, place)
    if text.value is not None and not part.lowest <= part.default <= part.highest:
        is_low = part.default < part.lowest
        limit = f"below the minimum, {part.lowest:g}" if is_low else f"above the maximum, {part.highest:g}"
        what = f"{part.default:g} is {limit}"
        yield Finding((*path, "value"), what, "write a value within the limits")
    if text.effect == "stored" and text.stored == "never":
        what = "it is in effect when it is stored, and it never is"
        yield Finding((*path, "effect"), what, "add stored: by_command")


def _block_findings(
    given: Mapping[Any, Any], places: MutableMapping[KeyPath, RegisterPlace]
) -> Iterator[Finding]:
    blocks = given.get("blocks")
    taken: dict[tuple[Table, int], str] = {}
    at = {
        (place.table, register): path
        for path, place in places.items()
        for register in range(place.address, place.address + place.width)
    }
    known = blocks_of(given)
    for name, each in blocks.items() if isinstance(blocks, dict) else ():
        if not isinstance(each, dict):
            continue
        path: KeyPath = ("blocks", name)
        tables = [word for word in ("input", "holding") if each.get(word) is not None]
        if len(tables) != 1:
            what = f"{' and '.join(tables)} are both given" if tables else "no table is given"
            yield Finding(path, f"{what}; a block is in one table", "write input or holding")
            continue
        if (block := known.get(str(name))) is None:
            continue
        start = block.table, block.address
        if start in taken:
            what = f"the block {taken[start]} begins there, too"
            yield Finding((*path, tables[0]), what, "write another address")
        elif start in at:
            whose = ".".join(map(str, at[start]))
            yield Finding(
                (*path, tables[0]), f"{tables[0]} {block.address} is {whose}", "write another address"
            )
        taken[start] = str(name)
        if block.address + block.registers > ADDRESSES:
            what = f"the block ends behind {ADDRESSES - 1}"
            yield Finding((*path, "registers"), what, f"write {ADDRESSES - block.address} or less")
        if block.words and block.table is Table.INPUT_REGISTERS:
            yield Finding((*path, "then"), "nobody writes input registers", "write holding", at_key=True)


def _protocol_findings(
    given: Mapping[Any, Any], places: Mapping[KeyPath, RegisterPlace]
) -> Iterator[Finding]:
    protocol = given.get("protocol")
    if not isinstance(protocol, dict):
        return
    causes = protocol.get("exceptions")
    for cause in causes if isinstance(causes, dict) else ():
        if cause not in CAUSES:
            wrong = no_such(("protocol", "exceptions", cause), "cause", str(cause), CAUSES)
            yield Finding(wrong.path, wrong.message, wrong.remedy, at_key=True)
    functions = protocol.get("functions")
    if not isinstance(functions, list) or not all(isinstance(each, int) for each in functions):
        return
    path: KeyPath = ("protocol", "functions")
    lacking: dict[int, str] = {}
    blocks = {block.number: block.registers for block in blocks_of(given).values()}
    for where, place in places.items():
        reader = _READERS[place.table]
        if reader not in functions and not (reader == 3 and 23 in functions):
            lacking.setdefault(reader, ".".join(map(str, where)))
        width = blocks.get(place.address >> 16, place.width)
        writers = _WRITERS.get((place.table, width > 1), ()) if _is_written(where) else ()
        if writers and not set(writers) & set(functions):
            lacking.setdefault(writers[0], ".".join(map(str, where)))
    if lacking:
        missing = ", ".join(f"{function} for {whose}" for function, whose in sorted(lacking.items()))
        numbers = ", ".join(map(str, sorted(lacking)))
        yield Finding(path, f"functions are missing: {missing}", f"add {numbers}, or put these elsewhere")


def _is_written(path: KeyPath) -> bool:
    """True if a master has to write what is at a path, to command the drive."""
    own = path[2:] if path[0] == "blocks" else path
    return own[0] in _COMMANDED or own[-1] in TAKEN or own[-1] in MORE_TAKEN
