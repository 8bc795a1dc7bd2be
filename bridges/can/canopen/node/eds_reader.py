"""Objects of a maker's EDS or DCF as the entries of a node, and every mistake that keeps one from being made
of it.

A file that tools take is taken: comments, octal numbers, lists of compact objects, empty defaults. A mistake
is what no node could be made of: a mapping of what is not there, limits the wrong way round, no type.

Source: CiA 306-1 version 1.3.0, 4.5 (device information), 4.6 (objects), 6 (compact storage), 7 (DCF).
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

from bridges.can.canopen.eds_sections import (
    NAMES,
    VALUES,
    WHOLE,
    EdsFields,
    EdsText,
    number_of,
    without_comment,
)
from bridges.can.canopen.node.application import Access, DataType, Entry
from bridges.can.canopen.node.eds_entries import EntryReader, Key, plain_number, text_of_field
from bridges.can.canopen.node.eds_mappings import mapping_problems
from hil.vocab.problem import ConfigError, Problem

_MANDATORY = {0x1000: "Device type", 0x1001: "Error register", 0x1018: "Identity object"}
_LISTS = ("mandatoryobjects", "optionalobjects", "manufacturerobjects")
_ARRAY, _RECORD, _DEFTYPE, _DEFSTRUCT = 8, 9, 5, 6
_MOST_SUBINDICES = 254
_MOST_ENTRIES = 30_000
"""Number of entries of a file, ten times those of the largest drives: 64 bytes can make 254 of them."""
_RATE = re.compile(r"baudrate_(\d+)")
_K = 1000


class EdsInfo(NamedTuple):
    """Information on the device. Numbers are 0 and texts empty where the file has none."""

    vendor_name: str
    product_name: str
    vendor_number: int
    product_number: int
    revision_number: int
    bit_rates: tuple[int, ...]
    """Bits per second that it knows; empty: the file does not say."""
    has_lss: bool


class EdsDevice(NamedTuple):
    """Device of a file. ``names``: of all objects, empty for those without sub-indices; ``given``: keys of
    the entries whose values are in the file."""

    entries: Mapping[Key, Entry]
    names: Mapping[int, str]
    given: frozenset[Key]
    info: EdsInfo


def read_device(text: str, file: str) -> EdsDevice:
    """Read a file. Values of a DCF stand above those of its EDS.

    Raises:
        ConfigError: with all problems, in the order of the file.
    """
    device, problems = _read(text)
    if problems:
        raise ConfigError([replace(each, file=file) for each in problems])
    return device


@lru_cache(maxsize=16)
def _read(text: str) -> tuple[EdsDevice, Sequence[Problem]]:
    """Read a text once: checks and bench ask for it, and many nodes have one file."""
    reader = _DeviceReader(EdsText(text))
    return reader.read(), sorted(reader.problems, key=lambda each: (each.line, each.column))


class _DeviceReader:
    def __init__(self, text: EdsText) -> None:
        self._text = text
        self.problems: list[Problem] = []
        self._entries: dict[Key, Entry] = {}
        self._names: dict[int, str] = {}
        self._reader = EntryReader(self._add)
        self._with_parts = {index for index, part in text.objects if part > 0}

    def read(self) -> EdsDevice:
        objects = self._text.objects
        if not objects and not self._text.others:
            message = "this is no data sheet (EDS): it has no [section]"
            self.problems.append(self._problem(1, message, "give the file of the drive's maker"))
            return EdsDevice({}, {}, frozenset(), self._info())
        for (index, part), fields in objects.items():
            if part == WHOLE:
                self._read_object(index, fields)
            elif part >= 0:
                self._read_entry(index, part, fields)
            if len(self._entries) > _MOST_ENTRIES:
                message = f"there are more than {_MOST_ENTRIES} objects and sub-indices"
                self._add(self._place((index, part)), message, "leave those out that no drive has")
                break
        for index, part in objects:
            if part >= 0 and index not in self._names:
                self._names[index] = f"{index:04X}h"
        self._check_lists()
        self.problems += (
            self._problem(self._reader.spots.get(key, self._text.spots.get(key, 1)), message, remedy)
            for key, message, remedy in mapping_problems(self._entries)
        )
        return EdsDevice(self._entries, self._names, frozenset(self._reader.given), self._info())

    def _info(self) -> EdsInfo:
        fields = self._text.others.get("deviceinfo", {})

        def number(key: str) -> int:
            return plain_number(fields, key) & 0xFFFF_FFFF

        rates = [int(found[1]) for key in fields if (found := _RATE.fullmatch(key)) and number(key)]
        return EdsInfo(
            text_of_field(fields, "vendorname"),
            text_of_field(fields, "productname"),
            number("vendornumber"),
            number("productnumber"),
            number("revisionnumber"),
            tuple(rate * _K for rate in sorted(rates)),
            bool(number("lss_supported")),
        )

    # ---- objects ----

    def _read_object(self, index: int, fields: EdsFields) -> None:
        kind = plain_number(fields, "objecttype")
        count = plain_number(fields, "compactsubobj")
        name = text_of_field(fields, "parametername") or f"{index:04X}h"
        if count > 0:
            self._names[index] = name
            self._read_compact(index, name, min(count, _MOST_SUBINDICES), fields)
        elif kind in (_ARRAY, _RECORD) or ("datatype" not in fields and index in self._with_parts):
            self._names[index] = name
        elif kind not in (_DEFTYPE, _DEFSTRUCT):
            self._names[index] = ""
            self._read_entry(index, 0, fields)

    def _read_compact(self, index: int, name: str, count: int, fields: EdsFields) -> None:
        """Read an object whose sub-indices have no sections: all are alike except lists of names, values."""
        names, values = (self._text.objects.get((index, part), {}) for part in (NAMES, VALUES))
        self._entries.setdefault(
            (index, 0),
            Entry(index, 0, "Highest sub-index supported", DataType.UNSIGNED8, Access.CONST, count),
        )
        self._reader.given.add((index, 0))
        for subindex in range(1, count + 1):
            if (index, subindex) not in self._text.objects:
                own = dict(fields)
                own["parametername"] = names.get(str(subindex), (f"{name} {subindex}", 0))
                if value := values.get(str(subindex)):
                    own["parametervalue"] = value
                self._read_entry(index, subindex, own)

    def _read_entry(self, index: int, subindex: int, fields: EdsFields) -> None:
        key = index, subindex
        is_count = subindex == 0 and bool(self._names.get(index))
        if entry := self._reader.read(key, fields, self._place(key), is_count=is_count):
            self._entries[key] = entry

    # ---- the whole ----

    def _check_lists(self) -> None:
        indexes = {index for index, _ in self._entries}
        for index, name in _MANDATORY.items():
            if index not in indexes:
                remedy = f"add its section [{index:04X}], and list it in [MandatoryObjects]"
                self._add(1, f"{index:04X}h, {name}, is missing, which each node has", remedy)
        known = {index for index, _ in self._text.objects}
        for section in _LISTS:
            for key, (text, at) in self._text.others.get(section, {}).items():
                listed = number_of(without_comment(text), 0)
                if key.isdecimal() and listed is not None and listed not in known:
                    message = f"{listed:04X}h is listed, and has no section"
                    self._add(at, message, f"add [{listed:04X}], or take it out of the list")

    def _place(self, key: Key) -> int:
        spots = self._text.spots
        return spots.get(key, spots.get((key[0], WHOLE), 1))

    def _add(self, at: int, message: str, remedy: str) -> None:
        self.problems.append(self._problem(at, message, remedy))

    def _problem(self, at: int, message: str, remedy: str) -> Problem:
        return Problem("", at, self._text.column(at), message, remedy)
