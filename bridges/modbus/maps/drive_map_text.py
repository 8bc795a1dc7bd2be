"""Reader of a Modbus drive's map: YAML text to a ``DriveMap``, or every problem with its place."""

from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from bridges.modbus.maps.drive_map_model import LATEST_VERSION, MAP_VERSION, MapText
from bridges.modbus.maps.drive_map_overlaps import overlap_findings
from bridges.modbus.maps.map_part_findings import (
    MOVE_MARK,
    axis_findings,
    end_findings,
    part_findings,
    version_findings,
)
from bridges.modbus.maps.map_part_rows import as_given
from bridges.modbus.maps.map_parts_text import parts_of
from bridges.modbus.maps.map_places import OTHER, place_findings, place_of, quantity_of
from bridges.modbus.maps.map_row_models import TABLES, PlaceText
from bridges.modbus.registers.drive_map import (
    COMMANDS,
    CONTROL,
    IDENTITY,
    STATUS,
    DriveMap,
    RegisterPlace,
)
from hil.config.document import Document, Finding, KeyPath
from hil.config.document_kinds import DRIVE_MAP, check_kind
from hil.config.explain import findings_of, no_such
from hil.config.yaml_text import document_from_yaml
from hil.vocab.drive_words import MORE_TAKEN, MORE_TOLD, TAKEN, TOLD
from hil.vocab.near_words import did_you_mean

VALUES = {**TOLD, **TAKEN, **MORE_TOLD, **MORE_TAKEN}
_BIT_TABLES, _WRITABLE = ("discrete", "coil"), ("holding", "coil")
_EXAMPLES = {
    "position_deg": "position_deg: {input: 0, type: i32, scale: 0.01}",
    "set_point_deg": "set_point_deg: {holding: 10, type: i32, scale: 0.01}",
    "enable": "enable: {holding: 20, bit: 0}",
    "start": "start: {holding: 20, bit: 1}",
}


def read_drive_map(text: str, file: str, parameters: Collection[str] | None = None) -> DriveMap:
    """Read a map, as ``read_map_text``."""
    return drive_map_of(read_map_text(text, file, parameters))


def read_map_text(text: str, file: str, parameters: Collection[str] | None = None) -> MapText:
    """Read a map. ``file`` is the name that problems carry; nothing is opened. ``parameters``: names of the
    fields that its parameters may be; None: any.

    Raises:
        ConfigError: with all problems, in file order.
    """
    document = document_from_yaml(text, file)
    if document.value is None and not document.findings:
        raise document.error([Finding((), "the file is empty", f'begin with "modbus_map: {MAP_VERSION}"')])
    check_kind(document, DRIVE_MAP)
    findings = [*document.findings, *map_findings(document, (), parameters)]
    if findings:
        raise document.error(findings)
    return MapText.model_validate(document.value)


def map_findings(
    document: Document, at: KeyPath = (), parameters: Collection[str] | None = None
) -> list[Finding]:
    """Findings of the map at a path of a document, beside those of its text. ``parameters``: as
    ``read_map_text``."""
    given: Any = document.value
    for part in at:
        given = given[part]
    findings: list[Finding] = []
    try:
        MapText.model_validate(given)
    except ValidationError as error:
        findings += findings_of(error, MapText, at, document)
    entries = dict(_entries(given))
    is_new = isinstance(given, dict) and given.get("modbus_map") == LATEST_VERSION
    places: dict[KeyPath, RegisterPlace] = {}
    found: list[Finding] = []
    for path, entry in entries.items():
        wrong = list(_entry_findings(path, entry))
        found += wrong
        if not wrong:
            places[path] = _place(path, entry)
    if is_new:
        found += part_findings(given, places)
    else:
        found += version_findings(given, entries)
    found += overlap_findings(places, {path: document.keys[*at, *_written(path)].line for path in places})
    found = [replace(each, path=_written(each.path)) for each in found]
    found += _unknown_parameters(entries, parameters)
    if is_new:
        found += axis_findings(given, parameters)
    findings += (replace(each, path=(*at, *each.path)) for each in found)
    inner = [each.path[len(at) :] for each in findings]
    meant = {(path[:-1], each.remedy) for path, each in zip(inner, findings, strict=True)}
    wrong_paths = {each.path for each in (*findings, *document.findings)}
    for each in () if is_new else _missing(given, meant):
        whole = replace(each, path=(*at, *each.path))
        if whole.path not in wrong_paths:
            findings.append(whole)
    return findings


def drive_map_of(of: MapText) -> DriveMap:
    """Map that a text without findings is."""
    places = {path: _place(path, entry) for path, entry in _entries(as_given(of))}

    def room(name: str) -> dict[str, RegisterPlace]:
        return {str(path[1]): place for path, place in places.items() if path[0] == name and len(path) == 2}

    identity = {key: text for key in IDENTITY if (text := getattr(of.identity, key))}
    values = {str(path[0]): place for path, place in places.items() if len(path) == 1}
    rooms = room("status"), room("control"), room("parameters")
    if of.modbus_map == MAP_VERSION:
        return DriveMap(of.word_order, identity, values, *rooms)
    parts, in_blocks = parts_of(of)
    also = []
    for name, place in in_blocks:
        if name in values:
            also.append((name, place))
        else:
            values[name] = place
    parts = replace(parts, also=tuple(also))
    return DriveMap(of.word_order, identity, values, *rooms, LATEST_VERSION, parts)


def _entries(given: object) -> Iterator[tuple[KeyPath, PlaceText]]:
    """Entries that can be read, in file order, whatever is wrong with the others."""
    for key, value in given.items() if isinstance(given, dict) else ():
        paths: dict[KeyPath, object] = {}
        if key in VALUES:
            paths = {(key,): value}
        elif key in ("status", "control", "parameters") and isinstance(value, dict):
            rooms: dict[str, Collection[str]] = {"status": STATUS, "control": CONTROL, "parameters": value}
            paths = {(key, name): each for name, each in value.items() if name in rooms[key]}
        for path, each in paths.items():
            try:
                yield path, PlaceText.model_validate(each)
            except ValidationError:
                continue  # told by the check of the whole map


def _entry_findings(path: KeyPath, entry: PlaceText) -> Iterator[Finding]:
    """Findings of one entry that no other entry has a part in."""
    is_bit, tables = path[0] in ("status", "control"), entry.tables
    allowed = _allowed(path)
    example = f"{{{allowed[0]}: 0{', bit: 0' if is_bit else ''}}}"
    remedy = f"write {' or '.join(allowed)}, as in {example}"
    if len(tables) != 1:
        what = f"{' and '.join(tables)} are both given" if tables else "no table is given"
        yield Finding(path, f"{what}; an entry is in one table", remedy)
        return
    (table,) = tables
    if table not in allowed:
        is_no_value = table in _BIT_TABLES and not is_bit
        why = "is a value, which takes registers" if is_no_value else "is written by the client"
        yield Finding((*path, table), f"{path[-1]} {why}", remedy, at_key=True)
        return
    if is_bit:
        if table not in _BIT_TABLES and entry.bit is None:
            remedy = f"add which, 0 for the lowest: {{{table}: {getattr(entry, table)}, bit: 0}}"
            yield Finding(path, f"{path[-1]} is a bit of a register", remedy)
        if table in _BIT_TABLES and entry.bit is not None:
            yield Finding((*path, "bit"), f"a {table} is a single bit already", "remove it", at_key=True)
    elif entry.bit is not None:
        yield Finding((*path, "bit"), f"{path[-1]} is a value and no bit", "remove it", at_key=True)
    for key in ("type", "scale"):
        if is_bit and key in entry.model_fields_set:
            yield Finding((*path, key), f"{path[-1]} is a bit, which has no {key}", "remove it", at_key=True)
    if "on_write" in entry.model_fields_set and (path[0] != "control" or path[-1] not in COMMANDS):
        what = f"{path[-1]} is no command, which {', '.join(COMMANDS)} are"
        yield Finding((*path, "on_write"), what, "remove it", at_key=True)
    if path[0] != "parameters":
        quantity = quantity_of(str(path[0])) if len(path) == 1 else OTHER
        yield from place_findings(path, entry, is_bit=is_bit, quantity=quantity)
    yield from end_findings(path, entry, table, is_bit=is_bit)


def _written(path: KeyPath) -> KeyPath:
    """Path as it stands in the file: without the numbers of moves, which are rows of one place."""
    return tuple(part for part in path if not str(part).startswith(MOVE_MARK))


def _allowed(path: KeyPath) -> list[str]:
    """Words of the tables in which an entry can be."""
    is_bit = path[0] in ("status", "control")
    is_told = path[0] == "status" or path[0] in TOLD or path[0] in MORE_TOLD
    return [word for word in TABLES if (is_bit or word not in _BIT_TABLES) and (is_told or word in _WRITABLE)]


def _place(path: KeyPath, entry: PlaceText) -> RegisterPlace:
    (table,) = entry.tables
    address = getattr(entry, table)
    is_bit = path[0] in ("status", "control")
    quantity = None if len(path) == 1 else OTHER
    return place_of(str(path[-1]), entry, TABLES[table], address, is_bit=is_bit, quantity=quantity)


def _unknown_parameters(entries: Collection[KeyPath], known: Collection[str] | None) -> Iterator[Finding]:
    for path in entries:
        if path[0] == "parameters" and known is not None and path[1] not in known:
            wrong = no_such(path, "parameter", str(path[1]), known)
            yield Finding(path, wrong.message, wrong.remedy, at_key=True)


def _missing(given: object, meant: Collection[tuple[KeyPath, str]]) -> Iterator[Finding]:
    """Findings of what no map can be without. ``meant``: remedies by the mapping that they are for: what is
    mistyped is not missing too."""
    if not isinstance(given, dict):
        return

    def is_there(where: KeyPath, name: str) -> bool:
        room = given if not where else given.get(where[0])
        return (isinstance(room, dict) and room.get(name) is not None) or (
            where,
            did_you_mean(name),
        ) in meant

    for name in ("position_deg", "set_point_deg"):
        if not is_there((), name):
            yield Finding((name,), "this key is missing", f'add the line "{_EXAMPLES[name]}"')
    if not is_there((), "control"):
        remedy = f'add "control:", and below it "{_EXAMPLES["enable"]}" and "{_EXAMPLES["start"]}"'
        yield Finding(("control",), "this key is missing", remedy)
        return
    if not isinstance(given.get("control"), dict):
        return
    if not is_there(("control",), "enable"):
        yield Finding(("control", "enable"), "this key is missing", f'add the line "{_EXAMPLES["enable"]}"')
    if not is_there(("control",), "start") and not is_there(("control",), "follow"):
        message = "start or follow is missing, without which nothing moves"
        yield Finding(("control", "start"), message, f'add the line "{_EXAMPLES["start"]}"')
