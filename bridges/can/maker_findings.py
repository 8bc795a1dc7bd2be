"""Checks of nodes with a maker's data sheet: the lines about its objects, its units, and what file, lines and
bus cannot have together."""

import re
from collections.abc import Iterator, Mapping
from typing import Any

from bridges.can.can_model import CanNodeConfig
from bridges.can.canopen.cia402.maker_drive import (
    FieldLine,
    Key,
    LikeLine,
    MakerLines,
    given_values,
    with_values,
)
from bridges.can.canopen.cia402.maker_units import contradictions, factors_of
from bridges.can.canopen.cia402.motor_axis import CURRENT
from bridges.can.canopen.cia402.objects import MODES, ROWS
from bridges.can.canopen.cia402_words import CONTROLWORD, STATUSWORD, mode_bit
from bridges.can.canopen.master.drive_units import GivenUnits, UnitsUnknown
from bridges.can.canopen.node.application import DataType, Entry, Value
from bridges.can.canopen.node.communication_entries import Identity, communication_entries
from bridges.can.canopen.node.data_types import REALS, bounds_of, size_of
from bridges.can.canopen.node.eds_mappings import mapping_problems
from bridges.can.canopen.node.eds_reader import EdsDevice, read_device
from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import shown, suggestion
from hil.vocab.address import DeviceParts, address_of
from hil.vocab.problem import ConfigError

_KEY = re.compile(r"(?:0x)?([0-9A-Fa-f]{4})h?(?::(\d{1,3}))?", re.IGNORECASE)
_EXAMPLE = "write its index and sub-index, as in 6081h or 607Dh:1"
_OWN = {(row.entry.index, row.entry.subindex): row.entry for row in ROWS}
_DRIVE = {CONTROLWORD: "Controlword", STATUSWORD: "Statusword"}
_LIMITS, _MODES_OF_DRIVE = 0x607D, 0x6502
_PROFILE = 0x2000


def maker_findings(
    bus_name: str, bus: Mapping[str, Any], devices: Mapping[str, ProfileInfo]
) -> Iterator[Finding]:
    """Findings about the nodes of one bus that have a maker's file, or keys for one."""
    for axis, node in bus["nodes"].items():
        if not isinstance(node, dict):
            continue
        path: KeyPath = ("can", bus_name, "nodes", axis)
        eds = node.get("eds")
        if not isinstance(eds, dict):
            if "eds" not in node:
                for key in ("units", "objects"):
                    if node.get(key):
                        message = "these are lines about a maker's data sheet, and there is none"
                        yield Finding((*path, key), message, "add eds: and its path", at_key=True)
            continue
        try:
            device = read_device(str(eds.get("text")), "")
        except ConfigError:
            continue  # said where the file was read
        yield from _NodeCheck(path, node, device, _fields(str(axis), devices)).findings()
        rate = bus.get("bit_rate", 500_000)
        if isinstance(rate, int) and device.info.bit_rates and rate not in device.info.bit_rates:
            rates = ", ".join(map(str, device.info.bit_rates))
            message = f"the drive of {axis} does not know {rate} bit/s ({eds.get('name')})"
            yield Finding(("can", bus_name, "bit_rate"), message, f"write one of {rates}")


def _fields(axis: str, devices: Mapping[str, ProfileInfo]) -> tuple[str, ...]:
    """Fields of an axis; nothing where there is no such axis, which is said elsewhere."""
    owner, part = address_of(axis)
    profile = devices.get(owner)
    axes = DeviceParts(profile.axes if profile else {})
    if profile is None or not axes or part not in axes:
        return ()
    return (CURRENT, *profile.kind(part or axes.first).fields)


class _NodeCheck:
    def __init__(
        self, path: KeyPath, node: Mapping[str, Any], device: EdsDevice, fields: tuple[str, ...]
    ) -> None:
        self._path, self._node, self._device, self._fields = path, node, device, fields
        raw = node.get("objects")
        self._objects = {key: _short(line) for key, line in raw.items()} if isinstance(raw, dict) else {}
        self._values: dict[Key, Value] = {}

    def findings(self) -> Iterator[Finding]:
        for key, line in self._objects.items():
            yield from self._line(key, line)
        given = given_values(self._device, MakerLines(values=self._values))
        yield from self._mappings()
        yield from self._units(given)
        yield from self._drive(given)

    # ---- lines ----

    def _line(self, name: str, line: Any) -> Iterator[Finding]:
        here = (*self._path, "objects", name)
        key = key_of_line(name)
        if key is None:
            yield Finding(here, f"{shown(name)} is no object", _EXAMPLE, at_key=True)
            return
        entry = self._device.entries.get(key)
        if entry is None or (":" not in name and self._device.names.get(key[0])):
            yield self._no_such(here, key, name)
        elif isinstance(line, dict):
            yield from self._bound(here, key, entry, line)
        elif line is not None:
            value = _value_of(line, entry)
            if isinstance(value, str):
                yield Finding(here, value, "write what the object can have")
            elif (own := _OWN.get(key)) and own.is_live:
                message = f"{_shown(key)} tells what the axis does, and has no first value"
                yield Finding(here, message, "leave it out", at_key=True)
            else:
                self._values[key] = value

    def _no_such(self, here: KeyPath, key: Key, name: str) -> Finding:
        parts = [sub for index, sub in self._device.entries if index == key[0] and sub]
        if parts:
            message = f"{key[0]:04X}h has the sub-indices {parts[0]} to {parts[-1]}"
            return Finding(here, message, f"write {key[0]:04X}h:{parts[0]}", at_key=True)
        known = [f"{index:04X}h" for index in self._device.names]
        remedy = suggestion(f"{key[0]:04X}h", known)
        return Finding(here, f"the data sheet has no {_shown(key)}", remedy, at_key=True)

    def _bound(self, here: KeyPath, key: Key, entry: Entry, line: Mapping[str, Any]) -> Iterator[Finding]:
        field, like = line.get("field"), line.get("like")
        if (field is None) == (like is None):
            message = "an object tells either a field of the axis or what another object has"
            yield Finding(
                here, message, "write {field: current_A, scale: 1000} or {like: 6064h}", at_key=True
            )
        elif not size_of(entry.data_type) or key[0] < _PROFILE:
            remedy = "leave it out" if key[0] < _PROFILE else "write a text, or leave it out"
            yield Finding(here, f"{_shown(key)} cannot tell what an axis does", remedy, at_key=True)
        elif line.get("scale") == 0:
            yield Finding((*here, "scale"), "with a scale of 0 it is always 0", "write another number")
        elif isinstance(field, str):
            if self._fields and field not in self._fields:
                message = f"the axis has no field {shown(field)}"
                yield Finding((*here, "field"), message, suggestion(field, self._fields))
        elif isinstance(like, str):
            of = key_of_line(like)
            target = (self._device.entries.get(of) or _OWN.get(of)) if of else None
            if target is None or not size_of(target.data_type) or of == key:
                message = f"{shown(like)} is no object that this one could be"
                yield Finding((*here, "like"), message, "write one of CiA 402, as 6064h or 607Ah")
            elif key_of_line_in(self._objects, of):
                message = f"{_shown(of or key)} is what a line says itself"
                yield Finding((*here, "like"), message, "write the same as there")

    # ---- the whole ----

    def _mappings(self) -> Iterator[Finding]:
        """Findings about PDOs whose mapping the lines change."""
        places = {key: name for name in self._objects if (key := key_of_line(name))}
        for place, message, remedy in mapping_problems(with_values(self._device, self._values)):
            name = places.get(place) or next((places[key] for key in places if key[0] == place[0]), None)
            if name is not None:
                yield Finding((*self._path, "objects", name), message, remedy)

    def _units(self, given: Mapping[Key, Value]) -> Iterator[Finding]:
        def number(index: int, subindex: int) -> int | None:
            value = given.get((index, subindex))
            return value if isinstance(value, int) else None

        lines = _units_of(self._node.get("units"))
        try:
            factors_of(number, lines)
        except UnitsUnknown as error:
            yield Finding(
                (*self._path, "eds"), str(error), "add units: {position_per_turn: 10000}", at_key=True
            )
            return
        if said := contradictions(number, lines):
            here = (*self._path, "units", "position_per_turn")
            yield Finding(here, f"the units contradict: {said}", "leave this key out, or write the same")

    def _drive(self, given: Mapping[Key, Value]) -> Iterator[Finding]:
        here = (*self._path, "eds")
        likes = {of for line in self._objects.values() if (of := _liked(line))}
        for index, name in _DRIVE.items():
            if (index, 0) not in self._device.entries and (index, 0) not in likes:
                remedy = f"add it to the file, or a line of its own object, as 2000h: {{like: {index:04X}h}}"
                message = f"it has no {index:04X}h, {name}, which a drive of CiA 402 has"
                yield Finding(here, message, remedy)
                return
        for key, own in _known().items():
            entry = self._device.entries.get(key)
            if entry and size_of(own.data_type) and not size_of(entry.data_type):
                message = f"{_shown(key)} is {entry.data_type.name}, and {own.data_type.name} in the standard"
                yield Finding((*here, _shown(key)), message, "correct its DataType")
        bits = given.get((_MODES_OF_DRIVE, 0))
        if isinstance(bits, int) and bits and not any(bits & mode_bit(mode) for mode in (*MODES, 7)):
            message = f"6502h is {bits:#x}: it has no mode of operation that hil's drives have"
            yield Finding(here, message, "write another, as objects: {6502h: 1}")
        low, high = (given.get((_LIMITS, each)) for each in (1, 2))
        if isinstance(low, int) and isinstance(high, int) and low > high:
            at = next(
                (
                    (*self._path, "objects", key)
                    for key in self._objects
                    if key_of_line(key) in ((_LIMITS, 1), (_LIMITS, 2))
                ),
                here,
            )
            message = f"the software limits 607Dh are reversed: {low} is above {high}"
            yield Finding(at, message, "write the lower one into 607Dh:1")


def _known() -> dict[Key, Entry]:
    """Entries that node and drive have a use for."""
    own = communication_entries(0, Identity(0, 0, 0, 0, ""))
    return {(each.index, each.subindex): each for each in own} | _OWN


def lines_of(config: CanNodeConfig) -> MakerLines:
    """Lines of a node that was checked."""
    assert config.eds is not None
    device = read_device(config.eds.text, config.eds.name)
    values: dict[Key, Value] = {}
    bound: dict[Key, FieldLine | LikeLine] = {}
    for name, line in config.objects.items():
        key = key_of_line(name)
        assert key is not None
        if line.value is not None:
            value = _value_of(line.value, device.entries[key])
            assert not isinstance(value, str)
            values[key] = value
        elif line.field is not None:
            bound[key] = FieldLine(line.field, line.scale)
        elif (of := key_of_line(line.like or "")) is not None:
            bound[key] = LikeLine(of, line.scale)
    units = config.units.model_dump() if config.units else {}
    return MakerLines(GivenUnits(**units), values, bound)


def _short(line: Any) -> Any:
    """First value alone of a line that has no more, as a log has it."""
    value = line.get("value") if isinstance(line, dict) else None
    has_more = isinstance(line, dict) and (line.get("field") or line.get("like"))
    return line if value is None or has_more else value


def key_of_line(text: str) -> Key | None:
    """Index and sub-index that a line names; None: it is none."""
    found = _KEY.fullmatch(text)
    return (int(found[1], 16), int(found[2] or 0)) if found else None


def key_of_line_in(objects: Mapping[str, Any], key: Key | None) -> bool:
    """True if a line says what this object tells."""
    return any(isinstance(line, dict) and key_of_line(name) == key for name, line in objects.items())


def _liked(line: Any) -> Key | None:
    like = line.get("like") if isinstance(line, dict) else None
    return key_of_line(like) if isinstance(like, str) else None


def _units_of(raw: Any) -> GivenUnits:
    """Units as they are written; what is no number is said elsewhere."""
    given = raw if isinstance(raw, dict) else {}
    known = GivenUnits.__dataclass_fields__
    numbers = {
        name: float(value)
        for name, value in given.items()
        if name in known and isinstance(value, int | float) and value > 0
    }
    return GivenUnits(**numbers)


def _value_of(line: float | str, entry: Entry) -> Value | str:
    """First value that a line gives an entry, or what is wrong with it, in words."""
    key = entry.index, entry.subindex
    if not size_of(entry.data_type):
        if isinstance(line, str) and entry.data_type is DataType.VISIBLE_STRING:
            return line.encode()
        return f"{_shown(key)} is {entry.data_type.name}, which no line can write"
    if isinstance(line, str | bool):
        return f"{_shown(key)} is {entry.data_type.name}, and {shown(line)} is no number"
    if entry.data_type in REALS:
        return float(line)
    low, high = bounds_of(entry.data_type)
    low = low if entry.low is None else max(low, int(entry.low))
    high = high if entry.high is None else min(high, int(entry.high))
    if float(line) != int(line) or not low <= line <= high:
        return f"{_shown(key)} is {low} to {high} in whole numbers, not {line:.10g}"
    return int(line)


def _shown(key: Key) -> str:
    return f"{key[0]:04X}h:{key[1]}" if key[1] else f"{key[0]:04X}h"
