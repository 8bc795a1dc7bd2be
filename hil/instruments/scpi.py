"""Commands in the forms of SCPI: ``[SOURce:]VOLTage[:LEVel] {voltage_V}``, long or short, in any case.

Sources: SCPI 1999, volume 1, chapter 6; IEEE 488.2, chapter 7.
"""

import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from itertools import product
from typing import NamedTuple

from hil.instruments.patterns import (
    ALIKE,
    NUMBER,
    Found,
    Literal,
    Match,
    Pattern,
    PatternRefused,
    Slot,
    SlotKind,
    match,
    read_pattern,
)

SWITCH_WORDS = (f"0{ALIKE}OFF", f"1{ALIKE}ON")
LIMITS = ("MINIMUM", "MAXIMUM", "DEFAULT")
"""Words for a number, in capital letters; their first three are the short forms."""
_NODE = re.compile(r"(\[?)(:?)(\*?[A-Za-z][A-Za-z_]*[0-9]*)(?:\{([A-Za-z_][A-Za-z0-9_]*)\})?(:?)(\]?)")
_WORD = r"[A-Za-z]+[0-9]*"
_SUFFIX = r"(.*?)([0-9]{0,4})"
_PREFIXES = {"M": 1e-3, "K": 1e3, "U": 1e-6, "N": 1e-9}
_MEGA = ("HZ", "OHM")
"""Units at which M is 1e6. Source: IEEE 488.2, 7.7.3."""
MOST_OPTIONS = 6


class Mnemonic(NamedTuple):
    """Word of a header, in capital letters; ``suffix``: name of the number that it may end in."""

    long: str
    short: str
    suffix: str


class TypedUnit(NamedTuple):
    """One of the commands of a line: its header's words, in capital letters, and what comes after."""

    words: tuple[str, ...]
    is_query: bool
    arguments: tuple[str, ...]


class ScpiCommand(NamedTuple):
    """Command in the forms of SCPI. ``headers``: its words, with and without those that may be left out;
    ``units``: units of its numbers, by the names of the places."""

    text: str
    headers: tuple[tuple[Mnemonic, ...], ...]
    is_query: bool
    arguments: tuple[Pattern, ...]
    units: Mapping[str, str]

    def fit(self, unit: TypedUnit, present: Callable[[Slot, Found], float | str | None]) -> Found | bool:
        """Values that a typed command gives; True: its header fits alone; False: it is another."""
        if unit.is_query != self.is_query:
            return False
        for header in self.headers:
            if (found := _suffixes(header, unit.words)) is not None:
                break
        else:
            return False
        if len(unit.arguments) != len(self.arguments):
            return True
        for pattern, text in zip(self.arguments, unit.arguments, strict=True):
            if (given := self.argument(pattern, text, present)) is None:
                return True
            found |= given
        return found

    def argument(
        self, pattern: Pattern, text: str, present: Callable[[Slot, Found], float | str | None]
    ) -> Found | None:
        """Value of an argument by the name of its place; none of a fixed word; None: it does not fit."""
        matched = match(pattern, text, 0, present)
        (slot,) = pattern.parts if len(pattern.parts) == 1 else (None,)
        if isinstance(slot, Literal):
            return {} if text.upper() in (slot.text, _short(pattern.text)) else None
        if isinstance(matched, Match) and matched.end == len(text):
            return matched.found
        if not isinstance(slot, Slot) or slot.kind.kind != NUMBER:
            return None
        if not isinstance(matched, Match):
            word = next((each for each in LIMITS if text.upper() in (each, each[:3])), None)
            return None if word is None else {slot.name: word}
        factor = factor_of(text[matched.end :].strip().upper(), self.units.get(slot.name, "").upper())
        value = matched.found[slot.name]
        return {slot.name: value * factor} if factor and isinstance(value, float) else None


def factor_of(typed: str, unit: str) -> float | None:
    """Factor of a unit that was typed, to a variable's; both in capital letters. None: it is another's."""
    if unit and typed == unit:
        return 1.0
    if not unit or not typed.endswith(unit) or (typed[:-1] and typed[1:] != unit):
        return None
    if typed[0] == "M" and unit in _MEGA:
        return 1e6
    return _PREFIXES.get(typed[0])


def read_command(
    text: str,
    kind_of: Callable[[str], SlotKind | None],
    units: Mapping[str, str],
) -> ScpiCommand:
    """Read a command's form. ``kind_of``: as ``read_pattern``. Raises PatternRefused: it is none."""
    header, _, rest = text.strip().partition(" ")
    is_query = header.endswith("?")
    nodes, at = [], 0
    body = header.removesuffix("?").removeprefix(":")
    while at < len(body):
        found = _NODE.match(body, at)
        if not found or bool(found[1]) != bool(found[6]):
            raise PatternRefused(
                f"{body[at:]!r} is no header",
                "write words as in [SOURce:]VOLTage[:LEVel]?, options not in options",
            )
        if found[4] and kind_of(found[4]) is None:
            raise PatternRefused(f'there is no variable "{found[4]}"', "")
        nodes.append((bool(found[1]), Mnemonic(found[3].upper(), _short(found[3]), found[4] or "")))
        at = found.end()
    options = [index for index, (is_option, _) in enumerate(nodes) if is_option]
    if not nodes or len(options) == len(nodes) or len(options) > MOST_OPTIONS:
        raise PatternRefused(
            f"{header!r} has no word that has to be there, or more than {MOST_OPTIONS} options",
            "write at least one word without [...]",
        )
    headers = []
    for kept in product((True, False), repeat=len(options)):
        left_out = {index for index, is_kept in zip(options, kept, strict=True) if not is_kept}
        headers.append(tuple(node for index, (_, node) in enumerate(nodes) if index not in left_out))
    arguments = tuple(
        read_pattern(each, kind_of, has_cases=False, two_words=SWITCH_WORDS) for each in split(rest, ",")
    )
    return ScpiCommand(text, tuple(headers), is_query, arguments, units)


def read_typed(unit: str, path: tuple[str, ...]) -> tuple[TypedUnit, tuple[str, ...]]:
    """Read one command of a line; answers the path, too, from which the next one of the line goes on.
    ``path``: words before those that are typed."""
    header, _, rest = unit.strip().replace("\t", " ").partition(" ")
    is_query = header.endswith("?")
    name = header.removesuffix("?").upper()
    arguments = tuple(split(rest, ","))
    if name.startswith("*"):
        return TypedUnit((name,), is_query, arguments), path
    if name.startswith(":"):
        path, name = (), name[1:]
    words = (*path, *name.split(":"))
    return TypedUnit(words, is_query, arguments), words[:-1]


def split(text: str, separator: str) -> list[str]:
    """Parts of a text between separators that are not in quotes, without blanks around them; a text of blanks
    has none."""
    if not text.strip():
        return []
    parts, quote, begin = [], "", 0
    for at, each in enumerate(text):
        if quote:
            quote = "" if each == quote else quote
        elif each in "\"'":
            quote = each
        elif each == separator:
            parts.append(text[begin:at].strip())
            begin = at + 1
    return [*parts, text[begin:].strip()]


def sample_header(header: tuple[Mnemonic, ...], is_long: bool) -> str:
    """Header as it may be typed."""
    return ":".join((each.long if is_long else each.short) + "1" * bool(each.suffix) for each in header)


@lru_cache(1024)
def _short(word: str) -> str:
    """Short form of a word: its capital letters and digits, or all of it."""
    if not re.fullmatch(_WORD, word):
        return word.upper()
    return "".join(each for each in word if each.isupper() or each.isdigit()) or word.upper()


def _suffixes(header: tuple[Mnemonic, ...], words: tuple[str, ...]) -> Found | None:
    """Numbers that the words end in, by name, 1 where there is none; None: they are others."""
    if len(header) != len(words):
        return None
    found: Found = {}
    for node, word in zip(header, words, strict=True):
        if node.suffix:
            parts = re.fullmatch(_SUFFIX, word)
            if parts is None:
                return None
            word = parts[1]
            found[node.suffix] = float(parts[2] or 1)
        if word not in (node.long, node.short):
            return None
    return found
