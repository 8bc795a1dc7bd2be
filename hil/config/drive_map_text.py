"""Reader of a Modbus drive's map: YAML text to a ``DriveMap``, or every problem with its place."""

from collections.abc import Collection, Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationError
from pydantic_core import PydanticCustomError

from hil.config.document import Document, Finding, KeyPath
from hil.config.drive_map_overlaps import overlap_findings
from hil.config.explain import StrictModel, findings_of, no_such
from hil.config.yaml_text import document_from_yaml
from hil.registers.cells import BIT
from hil.registers.drive_map import CONTROL, IDENTITY, STATUS, TAKEN, TOLD, DriveMap, Place
from hil.wire.modbus.identification import OBJECT_BYTES_MAX
from hil.wire.modbus.pdu import ADDRESSES, Table

VERSION = 1
"""Version of the format, ``modbus_map``."""
_TABLES = {
    "input": Table.INPUT_REGISTERS,
    "holding": Table.HOLDING_REGISTERS,
    "discrete": Table.DISCRETE_INPUTS,
    "coil": Table.COILS,
}
_BIT_TABLES, _WRITABLE = ("discrete", "coil"), ("holding", "coil")
_EXAMPLES = {
    "position_deg": "position_deg: {input: 0, type: i32, scale: 0.01}",
    "set_point_deg": "set_point_deg: {holding: 10, type: i32, scale: 0.01}",
    "enable": "enable: {holding: 20, bit: 0}",
    "start": "start: {holding: 20, bit: 1}",
}
_IDENTITY_CHARACTERS = OBJECT_BYTES_MAX
_MOST_SCALE = 1e12
_PARAMETER_NAME = "^[A-Za-z][A-Za-z0-9_]{0,31}$"


def _version(value: int) -> int:
    if value != VERSION:
        remedy = f"write {VERSION}, the version that is known here"
        raise PydanticCustomError("version", "there is no such version of the format", {"remedy": remedy})
    return value


def _usable_scale(value: float) -> float:
    if not 1 / _MOST_SCALE <= abs(value) <= _MOST_SCALE:
        what = f"a scale of {value:g} fits no value" if value else "with a scale of 0 every value is 0"
        remedy = "write what one step of the register is worth, as in 0.01"
        raise PydanticCustomError("scale", what, {"remedy": remedy})
    return value


def _ascii(value: str) -> str:
    if not value.isascii() or not value.isprintable() or len(value) > _IDENTITY_CHARACTERS:
        remedy = f"write at most {_IDENTITY_CHARACTERS} printable characters of ASCII"
        raise PydanticCustomError("ascii", "function 43/14 cannot tell this text", {"remedy": remedy})
    return value


_Address = Annotated[int, Field(ge=0, le=ADDRESSES - 1)]
_Text = Annotated[str, AfterValidator(_ascii)]


class PlaceText(StrictModel):
    """Entry of a map: one table with an address, and what is there."""

    input: _Address | None = None
    holding: _Address | None = None
    discrete: _Address | None = None
    coil: _Address | None = None
    type: Literal["u16", "i16", "u32", "i32", "f32"] | None = None
    scale: Annotated[float, AfterValidator(_usable_scale)] | None = None
    bit: Annotated[int, Field(ge=0, le=15)] | None = None

    @property
    def tables(self) -> list[str]:
        """Words of the tables that are named."""
        return [word for word in _TABLES if getattr(self, word) is not None]


class StatusText(StrictModel):
    """Bits that the drive tells."""

    enabled: PlaceText | None = None
    moving: PlaceText | None = None
    fault: PlaceText | None = None


class ControlText(StrictModel):
    """Bits that the drive takes."""

    enable: PlaceText | None = None
    start: PlaceText | None = None
    stop: PlaceText | None = None
    reset: PlaceText | None = None
    follow: PlaceText | None = None


class IdentityText(StrictModel):
    """Texts of what the drive says that it is."""

    vendor: _Text = ""
    product: _Text = ""
    revision: _Text = ""


class MapText(StrictModel):
    """A whole map."""

    modbus_map: Annotated[int, AfterValidator(_version)]
    word_order: Literal["high_first", "low_first"] = "high_first"
    identity: IdentityText = IdentityText()
    position_deg: PlaceText | None = None
    velocity_rpm: PlaceText | None = None
    current_A: PlaceText | None = None
    fault_code: PlaceText | None = None
    set_point_deg: PlaceText | None = None
    set_velocity_rpm: PlaceText | None = None
    acceleration_rpm_per_s: PlaceText | None = None
    status: StatusText = StatusText()
    control: ControlText | None = None
    parameters: Mapping[Annotated[str, Field(pattern=_PARAMETER_NAME)], PlaceText] = {}


def read_drive_map(text: str, file: str, parameters: Collection[str] | None = None) -> DriveMap:
    """Read a map. ``file`` is the name that problems carry; nothing is opened. ``parameters``: names of the
    fields that its parameters may be; None: any.

    Raises:
        ConfigError: with all problems, in file order.
    """
    document = document_from_yaml(text, file)
    given = document.value
    if given is None and not document.findings:
        raise document.error([Finding((), "the file is empty", f'begin with "modbus_map: {VERSION}"')])
    findings = list(document.findings)
    try:
        MapText.model_validate(given)
    except ValidationError as error:
        findings += findings_of(error, MapText, (), document)
    entries = dict(_entries(given))
    places: dict[KeyPath, Place] = {}
    for path, entry in entries.items():
        wrong = list(_entry_findings(path, entry))
        findings += wrong
        if not wrong and (place := _place(path, entry)) is not None:
            places[path] = place
    findings += overlap_findings(places, document)
    findings += _unknown_parameters(entries, parameters)
    findings += _missing(document, findings)
    if findings:
        raise document.error(findings)
    return _drive_map(MapText.model_validate(given), places)


def _entries(given: object) -> Iterator[tuple[KeyPath, PlaceText]]:
    """Entries that can be read, in file order, whatever is wrong with the others."""
    for key, value in given.items() if isinstance(given, dict) else ():
        paths: dict[KeyPath, object] = {}
        if key in TOLD or key in TAKEN:
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
        if is_bit and getattr(entry, key) is not None:
            yield Finding((*path, key), f"{path[-1]} is a bit, which has no {key}", "remove it", at_key=True)
    address = getattr(entry, table)
    if not is_bit and address + Place(_TABLES[table], 0, entry.type or "u16").width > ADDRESSES:
        yield Finding(
            (*path, table),
            f"{entry.type} takes two registers, and behind {address} there is none",
            f"write {ADDRESSES - 2} or less",
        )


def _allowed(path: KeyPath) -> list[str]:
    """Words of the tables in which an entry can be."""
    is_bit = path[0] in ("status", "control")
    is_told = path[0] == "status" or path[0] in TOLD
    return [
        word for word in _TABLES if (is_bit or word not in _BIT_TABLES) and (is_told or word in _WRITABLE)
    ]


def _place(path: KeyPath, entry: PlaceText) -> Place:
    (table,) = entry.tables
    address = getattr(entry, table)
    if path[0] in ("status", "control"):
        return Place(_TABLES[table], address, BIT, bit=entry.bit)
    return Place(_TABLES[table], address, entry.type or "u16", 1.0 if entry.scale is None else entry.scale)


def _unknown_parameters(entries: Collection[KeyPath], known: Collection[str] | None) -> Iterator[Finding]:
    for path in entries:
        if path[0] == "parameters" and known is not None and path[1] not in known:
            wrong = no_such(path, "parameter", str(path[1]), known)
            yield Finding(path, wrong.message, wrong.remedy, at_key=True)


def _missing(document: Document, findings: Collection[Finding]) -> Iterator[Finding]:
    """Findings of what no map can be without. A mistyped key is not missing too."""
    given: Any = document.value
    if not isinstance(given, dict):
        return
    meant = {(each.path[:-1], each.remedy) for each in findings}

    def is_there(where: KeyPath, name: str) -> bool:
        room = given if not where else given.get(where[0])
        return (isinstance(room, dict) and room.get(name) is not None) or (
            where,
            f'did you mean "{name}"?',
        ) in meant

    for name in ("position_deg", "set_point_deg"):
        if not is_there((), name) and (name,) not in {each.path for each in findings}:
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


def _drive_map(of: MapText, places: Mapping[KeyPath, Place]) -> DriveMap:
    def room(name: str) -> dict[str, Place]:
        return {str(path[1]): place for path, place in places.items() if path[0] == name and len(path) == 2}

    identity = {key: text for key in IDENTITY if (text := getattr(of.identity, key))}
    values = {str(path[0]): place for path, place in places.items() if len(path) == 1}
    return DriveMap(of.word_order, identity, values, room("status"), room("control"), room("parameters"))
