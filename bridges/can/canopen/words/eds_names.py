"""Names, types and first values of objects out of an EDS or DCF file.

Files of real devices are seldom right in everything. What is not needed is not looked at, a line that is none
is left out, and all else is read.

Source: CiA 306-1, 4.3 (numbers), 4.6 and 6.
"""

import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from bridges.can.canopen.words.object_words import TYPES_BY_NUMBER, ObjectName
from hil.wire.outside_text import LeftOut, lines_of

MOST_CHARACTERS = 8_000_000
_SECTION = re.compile(r"\[\s*([0-9A-Fa-f]{4})(?:sub([0-9A-Fa-f]{1,2})|(name|value))?\s*\]", re.IGNORECASE)
_NODE_ID = re.compile(r"\$NODEID", re.IGNORECASE)
_COMMENT = re.compile(r"\s*[;#].*")
_HAS_SUBINDICES = (8, 9)
"""Kinds of objects, arrays and records, whose section is about all of them."""
_OF_PDOS = range(0x1400, 0x1C00)
"""Objects whose first values are wanted: they say what PDOs have."""
_MOST_SUBINDICES = 254
_MOST_NAMES = 100_000
"""Number of names behind which objects without sections for their sub-indices have none: 64 bytes of a file
make 254 names. Files of devices have some thousands."""
_WHOLE, _NAMES, _VALUES = -1, -2, -3
"""Parts of an object beside its sub-indices: its section, and its lists of names and values."""
_Fields = dict[str, tuple[str, int]]
"""Entries of a section, with the numbers of their lines."""


class EdsError(ValueError):
    """Error of a file that is no EDS: ``str(error)`` says why."""


class EdsObjects(NamedTuple):
    """Names of a node's objects in a file, by index and sub-index; -1: the object as a whole."""

    names: Mapping[tuple[int, int], ObjectName]
    values: Mapping[tuple[int, int], bytes]
    """Values that objects of PDOs have at first."""


def read_eds(text: str, node: int, left_out: LeftOut) -> EdsObjects:
    """Read a file, for a node of this id, on which some values depend.

    Raises:
        EdsError: there is no object in it.
    """
    sections = _sections(text[:MOST_CHARACTERS], left_out)
    reader = _Reader(sections, node, left_out)
    for index, part in sections:
        if part >= _WHOLE:
            reader.read_section(index, part)
    if not reader.names:
        raise EdsError("there is no object in it, as [1000] with a ParameterName")
    return EdsObjects(reader.names, reader.values)


class _Reader:
    def __init__(self, sections: Mapping[tuple[int, int], _Fields], node: int, left_out: LeftOut) -> None:
        self._sections, self._node, self._left_out = sections, node, left_out
        self.names: dict[tuple[int, int], ObjectName] = {}
        self.values: dict[tuple[int, int], bytes] = {}

    def read_section(self, index: int, part: int) -> None:
        """Read the section of an object or a sub-index."""
        fields = self._sections[index, part]
        name, _ = fields.get("parametername", ("", 0))
        kind = TYPES_BY_NUMBER.get(self._plain(fields, "datatype"), "")
        count = self._plain(fields, "compactsubobj") if part == _WHOLE and name else 0
        if count > 0:
            self._take_compact(index, name, kind, min(count, _MOST_SUBINDICES), fields)
        elif name:
            is_whole = part == _WHOLE and self._plain(fields, "objecttype") in _HAS_SUBINDICES
            self.names[index, part] = ObjectName("" if is_whole else kind, name)
        if count <= 0:
            self._set(index, max(part, 0), fields.get("parametervalue"), fields.get("defaultvalue"))

    def _take_compact(self, index: int, name: str, kind: str, count: int, fields: _Fields) -> None:
        """Take an object whose sub-indices have no sections: they are alike except lists of names and of
        values. Sub-index 0 has their number; a section of one sub-index stands above both."""
        names, values = (self._sections.get((index, part), {}) for part in (_NAMES, _VALUES))
        self.names[index, _WHOLE] = ObjectName("", name)
        if len(self.names) > _MOST_NAMES:
            _, line = fields["compactsubobj"]
            self._left_out.add(f"line {line}", f"sub-indices behind {_MOST_NAMES} names")
            return
        self.names.setdefault((index, 0), ObjectName("u8", "Number of entries"))
        self._set(index, 0, (str(count), 0))
        for subindex in range(1, count + 1):
            own, _ = names.get(str(subindex), (f"{name} {subindex}", 0))
            self.names.setdefault((index, subindex), ObjectName(kind, own))
            self._set(index, subindex, values.get(str(subindex)), fields.get("defaultvalue"))

    def _set(self, index: int, subindex: int, *given: tuple[str, int] | None) -> None:
        """Set a first value, if it is one that is wanted: the first that is given and not empty."""
        if index not in _OF_PDOS or (subindex > 1 and index & 0x200 == 0):
            return
        texts = [(_COMMENT.sub("", each[0]), each[1]) for each in given if each]
        text, line = next((each for each in texts if each[0]), ("", 0))
        if not text:
            return
        value = _number(text, self._node)
        if value is None:
            self._left_out.add(f"line {line}", "no number, where one is needed for a PDO", text)
        else:
            size = 4 if subindex else 1
            self.values[index, subindex] = (value & (1 << 8 * size) - 1).to_bytes(size, "little")

    def _plain(self, fields: _Fields, key: str) -> int:
        """Number of an entry; 0 where there is none that is one."""
        text, _ = fields.get(key, ("", 0))
        return _number(_COMMENT.sub("", text), 0) or 0


def _sections(text: str, left_out: LeftOut) -> dict[tuple[int, int], _Fields]:
    sections: dict[tuple[int, int], _Fields] = {}
    fields: _Fields = {}
    for number, line in _lines(text):
        if line.startswith("["):
            found = _SECTION.match(line)
            fields = sections.setdefault(_key(found), {}) if found else {}
            if not found and "]" not in line:
                left_out.add(f"line {number}", "a section without an end, as in [1000]", line)
            continue
        key, equals, value = line.partition("=")
        if equals:
            fields[key.strip().lower()] = value.strip(), number
        else:
            left_out.add(f"line {number}", "no section and no entry, as in DataType=0x0007", line)
    return sections


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines with their numbers, without those that are empty or comments."""
    for number, line in enumerate(lines_of(text), 1):
        if (line := line.strip()) and not line.startswith((";", "#")):
            yield number, line


def _key(found: re.Match[str]) -> tuple[int, int]:
    if found[3]:
        return int(found[1], 16), _NAMES if found[3].lower() == "name" else _VALUES
    return int(found[1], 16), int(found[2], 16) if found[2] else _WHOLE


def _number(text: str, node: int) -> int | None:
    """Number as such files have it: decimal, hexadecimal behind 0x or octal behind 0, perhaps with the node
    id before or behind it; None: it is none."""
    total, sign = 0, 1
    for part in re.split(r"([+-])", _NODE_ID.sub(str(node), "".join(text.split()))):
        if part in ("+", "-"):
            sign = -1 if part == "-" else 1
        elif part:
            try:
                total += sign * _digits(part)
            except ValueError:
                return None
    return total


def _digits(text: str) -> int:
    """Raises ValueError: it is no number of at most 64 bits."""
    if not text.isascii() or len(text) > 20 or "_" in text:
        raise ValueError
    lower = text.lower()
    if lower.startswith("0x"):
        return int(lower[2:], 16)
    is_octal = lower.startswith("0") and not set(lower) & set("89")
    return int(lower, 8 if is_octal else 10)
