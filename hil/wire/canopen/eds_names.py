"""Names, types and first values of objects out of an EDS or DCF file.

Source: CiA 306-1, 4.6 and 6.
"""

import re
from collections.abc import Mapping
from typing import NamedTuple

from hil.wire.canopen.object_words import INTEGERS, TYPES_BY_NUMBER, ObjectName

MOST_CHARACTERS = 8_000_000
_SECTION = re.compile(r"\[\s*([0-9A-Fa-f]{4})(?:sub([0-9A-Fa-f]{1,2}))?\s*\]", re.IGNORECASE)
_ENTRY = re.compile(r"([A-Za-z0-9_ ]+?)\s*=\s*(.*)")
_NODE_ID = re.compile(r"\$NODEID\s*\+?\s*", re.IGNORECASE)
_HAS_SUBINDICES = ("8", "9")
"""Kinds of objects, arrays and records, whose section is about all of them."""


class EdsError(ValueError):
    """Error of a file that is no EDS: ``str(error)`` has the number of the line."""


class EdsObjects(NamedTuple):
    """Names of a node's objects in a file, by index and sub-index; -1: the object as a whole."""

    names: Mapping[tuple[int, int], ObjectName]
    values: Mapping[tuple[int, int], bytes]
    """Values that integers have at first."""


def read_eds(text: str, node: int) -> EdsObjects:
    """Read a file, for a node of this id, on which some values depend.

    Raises:
        EdsError: a line that is none of such a file, or a number that is none; or there is no object in it.
    """
    names: dict[tuple[int, int], ObjectName] = {}
    values: dict[tuple[int, int], bytes] = {}
    for key, fields in _sections(text[:MOST_CHARACTERS]).items():
        is_whole = fields.get("objecttype", ("7", 0))[0].lower().removeprefix("0x") in _HAS_SUBINDICES
        kind = "" if is_whole else TYPES_BY_NUMBER.get(_number(*fields.get("datatype", ("0", 0)), 0), "")
        names[key if key[1] >= 0 or is_whole else (key[0], -1)] = ObjectName(kind, fields["parametername"][0])
        given = fields.get("parametervalue") or fields.get("defaultvalue")
        if kind in INTEGERS and given and given[0]:
            size = INTEGERS[kind]
            value = _number(*given, node) & (1 << 8 * size) - 1
            values[key[0], max(key[1], 0)] = value.to_bytes(size, "little")
    if not names:
        raise EdsError("there is no object in it, as [1000] with a ParameterName")
    return EdsObjects(names, values)


def _sections(text: str) -> dict[tuple[int, int], dict[str, tuple[str, int]]]:
    """Entries of objects' sections, with the numbers of their lines."""
    sections: dict[tuple[int, int], dict[str, tuple[str, int]]] = {}
    fields: dict[str, tuple[str, int]] = {}
    for number, line in enumerate(text.split("\n"), 1):
        line = line.strip()
        if not line or line.startswith(";"):
            continue
        if line.startswith("["):
            if not line.endswith("]"):
                raise EdsError(f"line {number}: {line[:60]!r} has no end; write a section as in [1000]")
            fields = {}
            if found := _SECTION.fullmatch(line):
                key = int(found[1], 16), int(found[2], 16) if found[2] else -1
                fields = sections.setdefault(key, {})
        elif found := _ENTRY.fullmatch(line):
            fields[found[1].lower()] = found[2].strip(), number
        else:
            raise EdsError(f"line {number}: {line[:60]!r} is no section and no entry, as in DataType=0x0007")
    return {key: fields for key, fields in sections.items() if "parametername" in fields}


def _number(text: str, line: int, node: int) -> int:
    """Number as such files have it: decimal, or hexadecimal behind 0x, perhaps with the node id."""
    rest = _NODE_ID.sub("", text)
    try:
        return int(rest or "0", 0) + (node if rest != text else 0)
    except ValueError:
        raise EdsError(f"line {line}: {text[:60]!r} is no number") from None
