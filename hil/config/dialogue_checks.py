"""Checks of a whole table: commands that can never come, answers that take longer than there is time."""

from collections.abc import Hashable, Iterator
from itertools import zip_longest
from typing import NamedTuple

from hil.config.dialogue_model import DialogueInfo
from hil.config.dialogue_table import DIALOGUE
from hil.config.document import Finding, KeyPath, Spot
from hil.instruments.instrument_table import DialogueRow, InstrumentTable
from hil.instruments.matching import resolved, row_match, slots_of
from hil.instruments.patterns import Found, Literal, Slot, samples
from hil.instruments.scpi import Mnemonic, ScpiCommand, TypedUnit, read_typed, sample_header
from hil.vocab.time import NS_PER_MS

Rows = dict[int, DialogueRow]
_BITS = 10
"""Bits of a character on a line, 8N1."""


class _Seen(NamedTuple):
    """Row that comes before others, and its line in the file."""

    row: DialogueRow
    line: int


def table_findings(
    info: DialogueInfo,
    table: InstrumentTable,
    rows: Rows,
    spots: dict[KeyPath, Spot],
    baud: int | None,
) -> Iterator[Finding]:
    """Findings about a table that could be read. ``rows``: those that could, by their numbers; ``spots``:
    places in the file; ``baud``: speed of the board's line, None: bytes take no time."""
    yield from _unreached(table, rows, spots)
    ends = {end for end in table.cuts.ends if end}
    for index, row in rows.items():
        path: KeyPath = (DIALOGUE, "commands", index, "asks")
        yield from _form_findings(table, row, path, ends)
    for index, message in enumerate(table.messages):
        length = len(message.says.text) + len(table.answer_end)
        takes_ns = length * _BITS * 1_000_000_000 // baud if baud else 0
        if takes_ns > message.every_ns:
            times = f"it takes {takes_ns / NS_PER_MS:g} ms at {baud} baud"
            text = f"{times}, and comes each {message.every_ns / NS_PER_MS:g} ms"
            remedy = "write a longer every_ms, a shorter text, or a higher baud"
            yield Finding((DIALOGUE, "messages", index, "every_ms"), text, remedy)
    if info.scpi and info.encoding == "hex":
        yield Finding((DIALOGUE, "encoding"), "SCPI's forms are text", "leave scpi or encoding: hex out")
    if info.scpi and info.ignore_case:
        message_, remedy = "SCPI's forms have no cases", "leave this key out"
        yield Finding((DIALOGUE, "ignore_case"), message_, remedy, at_key=True)
    if table.cuts.size:
        yield from _size_findings(table, rows)


def _size_findings(table: InstrumentTable, rows: Rows) -> Iterator[Finding]:
    """Commands of another number of bytes than all are to have."""
    around = len(next(iter(_filled(table.prefix.parts, {})), "")) if table.prefix else 0
    around += table.check_sum.length if table.check_sum else 0
    for index, row in rows.items():
        sizes = {around + len(text) for text in _all_samples(table, row)}
        is_text = any(slot.kind.kind == "text" for slot in slots_of(row))
        if sizes and not is_text and table.cuts.size not in sizes:
            message = f"it has {min(sizes)} bytes, and command_bytes is {table.cuts.size}"
            yield Finding((DIALOGUE, "commands", index, "asks"), message, "this never comes: let both agree")


def _form_findings(
    table: InstrumentTable, row: DialogueRow, path: KeyPath, ends: set[str]
) -> Iterator[Finding]:
    text = row.command.text
    literals = () if isinstance(row.command, ScpiCommand) else row.command.parts
    if any(end in part.text for part in literals if isinstance(part, Literal) for end in ends):
        yield Finding(path, "a line end is in it: this never comes", "leave it out: it is cut off before")
    elif table.is_scpi and ";" in text:
        yield Finding(path, "a ; ends a command: this never comes", "write two commands")
    elif len(text) > table.cuts.longest and not row.takes:
        yield Finding(path, f"it is longer than longest, {table.cuts.longest}", "write a greater longest")


def _unreached(table: InstrumentTable, rows: Rows, spots: dict[KeyPath, Spot]) -> Iterator[Finding]:
    """Rows that never come: those before take all that fits."""
    before = _Before()
    for index, row in rows.items():
        path: KeyPath = (DIALOGUE, "commands", index, "asks")
        first: _Seen | None = None
        for text in _all_samples(table, row):
            if not _fits(table, row, text):
                continue
            taken = next((s for s in before.near(row, text) if _takes(table, s.row, row, text)), None)
            if taken is None:  # one text that it takes is enough, and of most rows that is the first
                break
            first = first or taken
        else:
            if first is None:
                yield Finding(path, "no command fits this", "look at the limits of its values")
                continue
            where = f"the one of line {first.line}" if first.line else f"{first.row.command.text!r}"
            message = f"this never comes: {where} takes all that fits it"
            yield Finding(path, message, "write the more special one first, or give one a when:")
        line = spots.get(path, Spot(0, 0)).line
        before.add(_Seen(row, line))


class _Before:
    """Rows that come before another: those that may take a text of its are found by how they begin."""

    def __init__(self) -> None:
        self._rows: dict[Hashable, list[_Seen]] = {}
        self._lengths: set[int] = set()

    def add(self, seen: _Seen) -> None:
        """Add a row."""
        command = seen.row.command
        if isinstance(command, ScpiCommand):
            for header in command.headers:
                self._rows.setdefault(_header_key(header, command), []).append(seen)
            return
        part = command.parts[0]
        text = part.text if isinstance(part, Literal) else ""
        self._lengths.add(len(text))
        self._rows.setdefault(text, []).append(seen)

    def near(self, row: DialogueRow, text: str) -> Iterator[_Seen]:
        """Rows that may take a text, which is one of a row's."""
        command = row.command
        if isinstance(command, ScpiCommand):
            for header in (command.headers[0], command.headers[-1]):
                yield from self._rows.get(_header_key(header, command), ())
            return
        compared = text if command.has_cases else text.upper()
        for length in sorted(self._lengths):
            yield from self._rows.get(compared[:length], ())


def _header_key(header: tuple[Mnemonic, ...], command: ScpiCommand) -> Hashable:
    return (*(word.short for word in header), command.is_query)


def _takes(table: InstrumentTable, earlier: DialogueRow, row: DialogueRow, text: str) -> bool:
    """True if an earlier row takes a text before a later one can."""
    if earlier.when and not (row.when and row.when.text == earlier.when.text):
        return False
    return _fits(table, earlier, text)


def _fits(table: InstrumentTable, row: DialogueRow, text: str) -> bool:
    typed: str | TypedUnit = read_typed(text, ())[0] if table.is_scpi else text
    found = row_match(row, typed, _any_value)
    return not isinstance(found, bool) and not resolved(table, row, found)[2]


def _any_value(slot: Slot, found: Found) -> float | str | None:
    """Present value of a place that has to be given it: that which a sample has."""
    return 1.0 if slot.bytes or slot.kind.words else slot.name if slot.kind.kind == "text" else 1.0


def _all_samples(table: InstrumentTable, row: DialogueRow) -> Iterator[str]:
    """Texts that are this command, in several of its forms."""
    known = (row.takes or {}, table.variables)
    limits = {
        slot.name: (each[slot.name].low, each[slot.name].high)
        for slot in slots_of(row)
        if (each := next((names for names in known if slot.name in names), None))
    }
    if not isinstance(row.command, ScpiCommand):
        yield from _filled(row.command.parts, limits)
        return
    arguments = [_filled(pattern.parts, limits) for pattern in row.command.arguments]
    columns = list(zip_longest(*arguments, fillvalue=None)) or [()]
    is_long = True
    for header in (row.command.headers[0], row.command.headers[-1]):
        for column in columns:
            given = ",".join(
                each if each is not None else all_[0] for each, all_ in zip(column, arguments, strict=True)
            )
            name = sample_header(header, is_long=is_long) + "?" * row.command.is_query
            is_long = not is_long
            yield f"{name} {given}".strip()


def _filled(parts: tuple[Literal | Slot, ...], limits: dict[str, tuple[float, float]]) -> list[str]:
    """Texts of a pattern, with samples at its places."""
    choices = [
        [part.text]
        if isinstance(part, Literal)
        else [_given(part)]
        if part.is_given
        else samples(part, limits)
        for part in parts
    ]
    count = max((len(each) for each in choices), default=0)
    if not all(choices):
        return []
    return ["".join(each[index % len(each)] for each in choices) for index in range(count)]


def _given(slot: Slot) -> str:
    if slot.bytes:
        return (1).to_bytes(slot.bytes, "little" if slot.is_low_first else "big").decode("latin-1")
    if slot.kind.words:
        return slot.kind.words[1]
    if slot.kind.kind == "text":
        return slot.name
    return format(1, f"0{slot.digits}d") if slot.digits else "1"
