"""Sections, entries and numbers of EDS and DCF files.

Files of real devices are seldom right in everything, so a line that is none of these is told and left out.

Source: CiA 306-1, 4.2 (sections) and 4.3 (numbers).
"""

import re
from collections.abc import Callable
from functools import lru_cache

from hil.wire.outside_text import lines_of

MOST_CHARACTERS = 8_000_000
WHOLE, NAMES, VALUES = -1, -2, -3
"""Parts of an object beside its sub-indices: its section, and its lists of names and values."""
EdsFields = dict[str, tuple[str, int]]
"""Entries of a section by their names in small letters: each text, and the number of its line."""
_SECTION = re.compile(r"\s*([0-9A-Fa-f]{4})(?:sub([0-9A-Fa-f]{1,2})|(name|value))?\s*", re.IGNORECASE)
_MOST_DIGITS = 20
"""Characters of a number of 64 bits."""
_NODE_ID = re.compile(r"\$NODEID", re.IGNORECASE)
_COMMENT = re.compile(r"\s*[;#].*")


class EdsText:
    """File by its sections. ``objects``: those of objects by index and part, a sub-index or one of the
    constants above; ``others``: the rest, by their names in small letters. ``left_out`` is told a line's
    number, a reason and the line."""

    def __init__(self, text: str, left_out: Callable[[int, str, str], None] = lambda *_: None) -> None:
        self._lines = lines_of(text[:MOST_CHARACTERS])
        self.objects: dict[tuple[int, int], EdsFields] = {}
        self.others: dict[str, EdsFields] = {}
        self.spots: dict[tuple[int, int], int] = {}
        """Lines of the sections of objects."""
        self._left_out = left_out
        fields: EdsFields = {}
        names: dict[str, str] = {}  # a file has few names, and each of them often
        for number, line in enumerate(self._lines, 1):
            key, equals, value = line.partition("=")
            name = names.get(key) if equals else None
            if name is None:
                plain = line.strip()
                if not plain or plain.startswith((";", "#")):
                    continue
                if plain.startswith("["):
                    fields = self._section(number, plain)
                    continue
                if not equals:
                    left_out(number, "no section and no entry, as in DataType=0x0007", plain)
                    continue
                name = names[key] = key.strip().lower()
            fields[name] = value.strip(), number

    def _section(self, number: int, line: str) -> EdsFields:
        """Begin a section; one that stands twice goes on."""
        name, end, _ = line[1:].partition("]")
        if not end:
            self._left_out(number, "a section without an end, as in [1000]", line)
            return {}
        if not (found := _SECTION.fullmatch(name)):
            return self.others.setdefault(name.strip().lower(), {})
        self.spots.setdefault(at := _key(found), number)
        return self.objects.setdefault(at, {})

    def column(self, number: int) -> int:
        """Column in a line at which its value begins, or the line itself where it has none."""
        line = self._lines[number - 1]
        key, equals, value = line.partition("=")
        is_entry = equals and not line.lstrip().startswith("[")
        begin = len(key) + 1 if is_entry else 0
        rest = value if is_entry else line
        return begin + len(rest) - len(rest.lstrip()) + 1


def _key(found: re.Match[str]) -> tuple[int, int]:
    if found[3]:
        return int(found[1], 16), NAMES if found[3].lower() == "name" else VALUES
    return int(found[1], 16), int(found[2], 16) if found[2] else WHOLE


def without_comment(text: str) -> str:
    """Leave out a comment behind a number."""
    return _COMMENT.sub("", text) if ";" in text or "#" in text else text


@lru_cache(maxsize=4096)
def number_of(text: str, node: int) -> int | None:
    """Number as such files have it: decimal, hexadecimal behind 0x or octal behind 0, perhaps with the node
    id before or behind it; None: it is none."""
    if text.isdecimal() and text.isascii() and not text.startswith("0"):
        return int(text) if len(text) <= _MOST_DIGITS else None
    total, sign = 0, 1
    for part in re.split(r"([+-])", _NODE_ID.sub(str(node), "".join(text.split()))):
        if part in ("+", "-"):
            sign = -1 if part == "-" else 1
        elif part:
            try:
                total += sign * _digits(part)
            except ValueError:
                return None
    return total if text else None


def _digits(text: str) -> int:
    """Raises ValueError: it is no number of at most 64 bits."""
    if not text.isascii() or len(text) > _MOST_DIGITS or "_" in text:
        raise ValueError
    lower = text.lower()
    if lower.startswith("0x"):
        return int(lower[2:], 16)
    is_octal = lower.startswith("0") and not set(lower) & set("89")
    return int(lower, 8 if is_octal else 10)
