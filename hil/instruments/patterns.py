"""Patterns of commands: literal text, and places for values, ``{voltage_V}``, ``{relay[n]}``, ``{n:02d}``.

A place takes as much as its kind allows, and never less: nothing is tried twice, so that a command is read in
time in proportion to its length. One space fits one or more spaces and tabs.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Literal as OneOf
from typing import NamedTuple

NUMBER, WHOLE, SWITCH, CHOICE, TEXT = "number", "whole", "switch", "choice", "text"
"""Kinds of values."""
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3}(?![0-9]))?")
_WHOLE = re.compile(r"[+-]?[0-9]+")
_BLANK = re.compile(r"[ \t]+")
_PLACE = r"(=?)([A-Za-z_][A-Za-z0-9_]*)(?:\[([A-Za-z_][A-Za-z0-9_]*|[0-9]+)\])?(?::(.*))?"
_DIGITS = r"0?([1-9])([dX])"
_BYTES = r"([1-8])(le)?"
_FORMAT = r"[+ ]?0?[0-9]{0,2}(?:\.[0-9]{1,2})?[dfeEgGxX]?"
ALIKE = "\x1f"
"""Character between words of one value."""
_CAPITALS = {ord(small): small.upper() for small in "abcdefghijklmnopqrstuvwxyz"}
"""Capital letters by small ones: those that take the same room."""
MOST_DIGITS = 15
"""Digits of a number that a place takes; with more it is no number."""


class PatternRefused(ValueError):
    """Error of a text that is no pattern: ``str(error)`` says why."""

    def __init__(self, message: str, remedy: str) -> None:
        super().__init__(message)
        self.remedy = remedy


class SlotKind(NamedTuple):
    """Kind of a place's value: words of a choice or a switch, by their values."""

    kind: str
    words: tuple[str, ...] = ()


class Literal(NamedTuple):
    """Text that has to stand there; of a pattern without cases, in capital letters."""

    text: str


class Slot(NamedTuple):
    """Place for a value. ``which``: which of several variables, a number or the name of another place;
    ``is_given``: it has to be the variable's present value; ``digits``, ``base``: fixed number of digits, 0:
    as many as there are; ``bytes``: number of bytes of a binary value, ``is_low_first`` their order."""

    name: str
    which: str
    kind: SlotKind
    is_given: bool = False
    digits: int = 0
    base: int = 10
    bytes: int = 0
    is_low_first: bool = False
    fixed: str = ""
    """Text of a ``Slot.is_given`` as a format."""


ByteOrder = OneOf["little", "big"]
Part = Literal | Slot
Found = dict[str, float | str]
"""Values of places, by their names."""


class Pattern(NamedTuple):
    """Pattern of a command. ``has_cases``: capital and small letters differ."""

    text: str
    parts: tuple[Part, ...]
    has_cases: bool = True

    def slots(self) -> Iterator[Slot]:
        """Places for values, in their order."""
        return (part for part in self.parts if isinstance(part, Slot))


class Match(NamedTuple):
    """Part of a text that fits: where the pattern ended, and the values of its places."""

    end: int
    found: Found


def read_pattern(
    text: str,
    kind_of: Callable[[str], SlotKind | None],
    *,
    has_cases: bool = True,
    is_hex: bool = False,
    two_words: tuple[str, ...] = ("0", "1"),
) -> Pattern:
    """Read a pattern. ``kind_of``: answers the kind of a name, None: there is no such name; ``is_hex``: what
    is between places are bytes in base 16; ``two_words``: words of a switch, where the place has none.

    Raises:
        PatternRefused: it is none.
    """
    parts: list[Part] = []
    for piece, is_place in pieces_of(text):
        if is_place:
            parts.append(_slot(piece, kind_of, is_hex, two_words))
        elif literal := bytes_text(piece) if is_hex else piece:
            parts.append(Literal(literal if has_cases else literal.translate(_CAPITALS)))
    pattern = Pattern(text, tuple(parts), has_cases)
    _check_ends(pattern)
    return pattern


def pieces_of(text: str) -> Iterator[tuple[str, bool]]:
    """Pieces of a text, and for each whether it stood in braces; ``{{`` and ``}}`` are one brace each. Raises
    PatternRefused: a brace has no other."""
    plain, at = "", 0
    while at < len(text):
        here = text[at]
        if text[at : at + 2] in ("{{", "}}"):
            plain += here
            at += 2
        elif here == "{":
            end = text.find("}", at)
            if end < 0:
                raise PatternRefused("a { has no }", "write {{ for a brace itself")
            if plain:
                yield plain, False
            yield text[at + 1 : end], True
            plain, at = "", end + 1
        elif here == "}":
            raise PatternRefused("a } has no {", "write }} for a brace itself")
        else:
            plain += here
            at += 1
    if plain:
        yield plain, False


def bytes_text(digits: str) -> str:
    """Characters of bytes that are written in base 16, as ``FF 01``. Raises PatternRefused."""
    try:
        return bytes.fromhex(digits).decode("latin-1")
    except ValueError:
        raise PatternRefused(
            f"{digits.strip()!r} are no bytes", 'write two digits a byte, as in "FF 01"'
        ) from None


def format_problem(text: str) -> str | None:
    """Remedy for a format of a number that Python has not, or None."""
    return (
        None
        if re.fullmatch(_FORMAT, text)
        else "write a format as .3f, 05.1f, +.2e, d or 02X, or words as OFF|ON"
    )


def _slot(
    piece: str, kind_of: Callable[[str], SlotKind | None], is_hex: bool, two_words: tuple[str, ...]
) -> Slot:
    found = re.fullmatch(_PLACE, piece.strip())
    if not found:
        raise PatternRefused(
            f"{{{piece}}} is no place for a value", "write a variable's name, as in {voltage_V} or {relay[n]}"
        )
    given, name, index, form = found[1] == "=", found[2], found[3] or "", found[4] or ""
    kind = kind_of(name)
    if kind is None:
        raise PatternRefused(f'there is no variable "{name}"', "")
    if is_hex:
        return _binary(piece, Slot(name, index, kind, given), form)
    if kind.kind == SWITCH or (kind.kind == WHOLE and "|" in form):
        words = tuple(form.split("|")) if form else two_words
        if len(set(words)) < len(words) or not all(words):
            raise PatternRefused(f"two words of {{{piece}}} are alike, or empty", "give each value a word")
        return Slot(name, index, SlotKind(CHOICE if kind.kind == WHOLE else SWITCH, words), given, fixed=form)
    if form and (kind.kind in (TEXT, CHOICE) or format_problem(form)):
        remedy = "leave the format out" if kind.kind in (TEXT, CHOICE) else format_problem(form) or ""
        raise PatternRefused(f"{form!r} is no format of {name}", remedy)
    if kind.kind == WHOLE and (fixed := re.fullmatch(_DIGITS, form)) and form[0] == "0":
        return Slot(name, index, kind, given, int(fixed[1]), 10 if fixed[2] == "d" else 16, fixed=form)
    return Slot(name, index, kind, given, fixed=form)


def _binary(piece: str, slot: Slot, form: str) -> Slot:
    if slot.kind.kind not in (WHOLE, SWITCH):
        raise PatternRefused(f"{slot.name} is no whole number, and no switch", "bytes have these alone")
    if not (found := re.fullmatch(_BYTES, form or "1")):
        remedy = "write the number of bytes, as in {count:2}, and le where the low byte is first: {count:2le}"
        raise PatternRefused(f"{{{piece}}} has a strange number of bytes", remedy)
    return Slot(
        slot.name, slot.which, slot.kind, slot.is_given, bytes=int(found[1]), is_low_first=bool(found[2])
    )


def _check_ends(pattern: Pattern) -> None:
    """Refuse two places of which the first would take what is the second's."""
    for here, after in zip(pattern.parts, pattern.parts[1:], strict=False):
        if not isinstance(here, Slot) or here.digits or here.bytes or here.kind.words:
            continue
        if isinstance(after, Slot):
            raise PatternRefused(
                f"nothing says where {{{here.name}}} ends and {{{after.name}}} begins",
                "write something between them, or a fixed number of digits, as in {n:02d}",
            )
        if here.kind.kind != TEXT and after.text[0] in "0123456789" + ".eE" * (here.kind.kind == NUMBER):
            raise PatternRefused(
                f"{{{here.name}}} takes the {after.text[0]!r} after it",
                "write a fixed number of digits: {n:02d}",
            )


def match(
    pattern: Pattern, text: str, at: int, present: Callable[[Slot, Found], float | str | None]
) -> Match | int:
    """Match a pattern with a text from a place on; answers how many parts fit where not all do. ``present``:
    answers the present value of a place that has to be given it."""
    found: Found = {}
    compared = text if pattern.has_cases else text.translate(_CAPITALS)
    for number, part in enumerate(pattern.parts):
        if isinstance(part, Literal):
            if (end := _after_literal(part.text, compared, at)) < 0:
                return number
            at = end
            continue
        after = pattern.parts[number + 1] if number + 1 < len(pattern.parts) else None
        until = after.text if isinstance(after, Literal) else ""
        if (taken := _taken(part, text, compared, at, until, pattern.has_cases)) is None:
            return number
        value, at = taken
        if part.is_given and present(part, found) != value:
            return number
        found[part.name] = value
    return Match(at, found)


def _after_literal(literal: str, text: str, at: int) -> int:
    """Place after a literal, or -1."""
    if " " not in literal:
        return at + len(literal) if text.startswith(literal, at) else -1
    for index, word in enumerate(literal.split(" ")):
        if index:
            if not (blank := _BLANK.match(text, at)):
                return -1
            at = blank.end()
        if not text.startswith(word, at):
            return -1
        at += len(word)
    return at


def _taken(
    slot: Slot, text: str, compared: str, at: int, until: str, has_cases: bool
) -> tuple[float | str, int] | None:
    """Value that stands at a place of a text, and where it ends; None: there is none."""
    if slot.bytes:
        data = text[at : at + slot.bytes].encode("latin-1", "replace")
        if len(data) < slot.bytes:
            return None
        order: ByteOrder = "little" if slot.is_low_first else "big"
        return float(int.from_bytes(data, order)), at + slot.bytes
    if slot.digits:
        digits = text[at : at + slot.digits]
        allowed = "0123456789" if slot.base == 10 else "0123456789ABCDEFabcdef"
        if len(digits) < slot.digits or digits.strip(allowed):
            return None
        return float(int(digits, slot.base)), at + slot.digits
    if slot.kind.words:
        return _word(slot.kind, compared, at, has_cases)
    if slot.kind.kind == TEXT:
        end = compared.find(until, at) if until else len(text)
        return (text[at:end], end) if end > at else None
    number = (_NUMBER if slot.kind.kind == NUMBER else _WHOLE).match(text, at)
    if not number or sum(map(str.isdigit, number[0])) > MOST_DIGITS:
        return None
    return float(number[0]), number.end()


def _word(kind: SlotKind, compared: str, at: int, has_cases: bool) -> tuple[float, int] | None:
    """The longest word of a choice that stands there, as its number."""
    best: tuple[float, int] | None = None
    for value, word in enumerate(kind.words):
        for each in word.split(ALIKE):
            wanted = each if has_cases else each.translate(_CAPITALS)
            if compared.startswith(wanted, at) and (best is None or at + len(wanted) > best[1]):
                best = float(value), at + len(wanted)
    return best


def samples(slot: Slot, limits: Mapping[str, tuple[float, float]]) -> list[str]:
    """Texts that a place takes, of each form that there is."""
    low, high = limits.get(slot.name, (0.0, 1.0))
    if slot.bytes:
        order: ByteOrder = "little" if slot.is_low_first else "big"
        most = (1 << 8 * slot.bytes) - 1
        values = {max(0, min(most, int(value))) for value in (low, (low + high) / 2, high)}
        return [value.to_bytes(slot.bytes, order).decode("latin-1") for value in sorted(values)]
    if slot.kind.words:
        return [each for word in slot.kind.words for each in word.split(ALIKE)]
    if slot.kind.kind == TEXT:
        return ["x", "Ab c", "1", "?"]
    values = {int(max(-1e15, min(1e15, value))) for value in (low, (low + high) / 2, high)}
    if slot.digits:
        form = f"0{slot.digits}{'d' if slot.base == 10 else 'X'}"
        return [format(value, form)[-slot.digits :] for value in sorted(values) if value >= 0]
    whole = [str(value) for value in sorted(values)]
    return whole if slot.kind.kind == WHOLE else [*whole, f"{(low + high) / 2 + 0.125:.6g}"[:15]]
