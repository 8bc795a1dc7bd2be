"""Sections, entries and numbers of EDS and DCF files.

Files of real devices are seldom right in everything, so a line that is none of these is told and left out.

Source: CiA 306-1, 4.2 (sections) and 4.3 (numbers).
"""

import re
from bisect import bisect_right
from collections.abc import Callable
from functools import lru_cache

MOST_CHARACTERS = 8_000_000
WHOLE, NAMES, VALUES = -1, -2, -3
"""Parts of an object beside its sub-indices: its section, and its lists of names and values."""
EdsFields = dict[str, tuple[str, int]]
"""Entries of a section by their names in small letters: each text, and where in the file it begins."""
_SECTION = re.compile(r"\s*([0-9A-Fa-f]{4})(?:sub([0-9A-Fa-f]{1,2})|(name|value))?\s*", re.IGNORECASE)
_LINE = re.compile(r"^[ \t]*(?:\[([^\]\n]*)(\])?|([^=;#\[\s][^=\n]*)=[ \t]*(.*)|([^;#\[\s].*))", re.MULTILINE)
"""Line that is not empty and no comment: a section, an entry, or neither."""
_NODE_ID = re.compile(r"\$NODEID", re.IGNORECASE)
_COMMENT = re.compile(r"\s*[;#].*")


class EdsText:
    """File by its sections. ``objects``: those of objects by index and part, a sub-index or one of the
    constants above; ``others``: the rest, by their names in small letters. ``left_out`` is told a place in
    the text, a reason and the line."""

    def __init__(self, text: str, left_out: Callable[[int, str, str], None] = lambda *_: None) -> None:
        self.text = text[:MOST_CHARACTERS].replace("\r\n", "\n").replace("\r", "\n")
        self.objects: dict[tuple[int, int], EdsFields] = {}
        self.others: dict[str, EdsFields] = {}
        self.spots: dict[tuple[int, int], int] = {}
        """Places of the sections of objects."""
        self._line_ends: list[int] = []
        fields: EdsFields = {}
        for found in _LINE.finditer(self.text):
            section, end, key, value, rest = found.groups()
            if key is not None:
                fields[key.strip().lower()] = value.rstrip(), found.start(4)
            elif section is None:
                left_out(found.start(), "no section and no entry, as in DataType=0x0007", rest)
            elif named := _SECTION.fullmatch(section) if end else None:
                fields = self.objects.setdefault(at := _key(named), {})
                self.spots.setdefault(at, found.start())
            else:
                fields = self.others.setdefault(section.strip().lower(), {}) if end else {}
                if not end:
                    left_out(found.start(), "a section without an end, as in [1000]", found[0])

    def line_and_column(self, at: int) -> tuple[int, int]:
        """Line and column of a place in the text, both from 1."""
        if not self._line_ends:
            self._line_ends = [-1, *(each.start() for each in re.finditer("\n", self.text))]
        line = bisect_right(self._line_ends, at - 1)
        return line, at - self._line_ends[line - 1]


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
    if not text.isascii() or len(text) > 20 or "_" in text:
        raise ValueError
    lower = text.lower()
    if lower.startswith("0x"):
        return int(lower[2:], 16)
    is_octal = lower.startswith("0") and not set(lower) & set("89")
    return int(lower, 8 if is_octal else 10)
