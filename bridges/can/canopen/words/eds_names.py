"""Names, types and first values of objects out of an EDS or DCF file.

Files of real devices are seldom right in everything. What is not needed is not looked at, a line that is none
is left out, and all else is read.

Source: CiA 306-1, 4.3 (numbers), 4.6 and 6.
"""

from collections.abc import Mapping
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
from bridges.can.canopen.words.object_words import TYPES_BY_NUMBER, ObjectName
from hil.wire.outside_text import LeftOut

_HAS_SUBINDICES = (8, 9)
"""Kinds of objects, arrays and records, whose section is about all of them."""
_OF_PDOS = range(0x1400, 0x1C00)
"""Objects whose first values are wanted: they say what PDOs have."""
_MOST_SUBINDICES = 254
_MOST_NAMES = 100_000
"""Number of names behind which objects without sections for their sub-indices have none: 64 bytes of a file
make 254 names. Files of devices have some thousands."""


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
    of_file = EdsText(text, lambda number, why, line: left_out.add(f"line {number}", why, line))
    reader = _Reader(of_file, node, left_out)
    for index, part in of_file.objects:
        if part >= WHOLE:
            reader.read_section(index, part)
    if not reader.names:
        raise EdsError("there is no object in it, as [1000] with a ParameterName")
    return EdsObjects(reader.names, reader.values)


class _Reader:
    def __init__(self, text: EdsText, node: int, left_out: LeftOut) -> None:
        self._sections = text.objects
        self._node, self._left_out = node, left_out
        self.names: dict[tuple[int, int], ObjectName] = {}
        self.values: dict[tuple[int, int], bytes] = {}

    def read_section(self, index: int, part: int) -> None:
        """Read the section of an object or a sub-index."""
        fields = self._sections[index, part]
        name, _ = fields.get("parametername", ("", 0))
        kind = TYPES_BY_NUMBER.get(self._plain(fields, "datatype"), "")
        count = self._plain(fields, "compactsubobj") if part == WHOLE and name else 0
        if count > 0:
            self._take_compact(index, name, kind, min(count, _MOST_SUBINDICES), fields)
        elif name:
            is_whole = part == WHOLE and self._plain(fields, "objecttype") in _HAS_SUBINDICES
            self.names[index, part] = ObjectName("" if is_whole else kind, name)
        if count <= 0:
            self._set(index, max(part, 0), fields.get("parametervalue"), fields.get("defaultvalue"))

    def _take_compact(self, index: int, name: str, kind: str, count: int, fields: EdsFields) -> None:
        """Take an object whose sub-indices have no sections: they are alike except lists of names and of
        values. Sub-index 0 has their number; a section of one sub-index stands above both."""
        names, values = (self._sections.get((index, part), {}) for part in (NAMES, VALUES))
        self.names[index, WHOLE] = ObjectName("", name)
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
        texts = [(without_comment(each[0]), each[1]) for each in given if each]
        text, line = next((each for each in texts if each[0]), ("", 0))
        if not text:
            return
        value = number_of(text, self._node)
        if value is None:
            self._left_out.add(f"line {line}", "no number, where one is needed for a PDO", text)
        else:
            size = 4 if subindex else 1
            self.values[index, subindex] = (value & (1 << 8 * size) - 1).to_bytes(size, "little")

    def _plain(self, fields: EdsFields, key: str) -> int:
        """Number of an entry; 0 where there is none that is one."""
        text, _ = fields.get(key, ("", 0))
        return number_of(without_comment(text), 0) or 0
