"""Choice of the row that a command is.

Rows are tried in the order of the table, and the first that fits is it. A row that fits by its text, but
whose condition does not hold or whose value is out of range, is passed over. Where no other fits, the error
is that of the first one that was passed over.
"""

from collections.abc import Callable
from typing import NamedTuple

from hil.instruments.instrument_table import (
    BAD_SUFFIX,
    BAD_VALUE,
    BAD_WORD,
    EXTRA_VALUE,
    MISSING_VALUE,
    OUT_OF_RANGE,
    UNKNOWN,
    WRONG_STATE,
    WRONG_VALUES,
    DialogueRow,
    InstrumentTable,
    Variable,
)
from hil.instruments.patterns import Found, Literal, Match, Pattern, Slot, match
from hil.instruments.scpi import LIMITS, ScpiCommand, TypedUnit
from hil.instruments.slow_values import PresentValues
from hil.instruments.table_expressions import Look, Value

Given = list[tuple[str, int | None, Value]]
"""Variables to be set: name, number, value."""


class RowOutcome(NamedTuple):
    """Row that a command is, with what it sets; None: there is none, and the kind of error."""

    row: DialogueRow | None
    given: Given
    error: str
    takes_ns: int


def fitting(table: InstrumentTable, typed: str | TypedUnit, values: PresentValues) -> RowOutcome:
    """Find the row of a command. The values know what it was given, then."""
    error = ""
    values.forget()
    for row in table.rows:
        found = row_match(row, typed, _present(values.look))
        if found is False:
            continue
        if isinstance(found, bool):
            problem = _wrong_value(row, typed, _present(values.look))
        else:
            local, given, problem = resolved(table, row, found)
            if not problem:
                values.knows(local)
                if row.when is None or row.when.value(values.look):
                    return RowOutcome(row, given, "", row.takes_ns)
                values.forget()
                problem = WRONG_STATE
        if _rank(problem) > _rank(error):
            error = problem
    return RowOutcome(None, [], error or UNKNOWN, table.rows[0].takes_ns if table.rows else 0)


def _rank(error: str) -> int:
    """Number by which an error goes before another: one of a row that is nearer to what was typed."""
    if error in (MISSING_VALUE, EXTRA_VALUE):
        return 1
    return 2 if error in (BAD_VALUE, *WRONG_VALUES) else 3 if error else 0


def _wrong_value(
    row: DialogueRow, typed: str | TypedUnit, present: Callable[[Slot, Found], Value | None]
) -> str:
    """Kind of error of a command whose beginning alone fits."""
    command = row.command
    if not isinstance(command, ScpiCommand) or not isinstance(typed, TypedUnit):
        return BAD_VALUE
    if len(typed.arguments) != len(command.arguments):
        return MISSING_VALUE if len(typed.arguments) < len(command.arguments) else EXTRA_VALUE
    for pattern, text in zip(command.arguments, typed.arguments, strict=True):
        if command.argument(pattern, text, present) is None:
            slot = pattern.parts[0]
            if isinstance(slot, Literal) or slot.kind.words:
                return BAD_WORD
            return BAD_SUFFIX if isinstance(match(pattern, text, 0, present), Match) else BAD_VALUE
    return BAD_VALUE


def row_match(
    row: DialogueRow, typed: str | TypedUnit, present: Callable[[Slot, Found], Value | None]
) -> Found | bool:
    """Values that a command gives to a row; True: only its beginning fits; False: it is another command."""
    if isinstance(row.command, ScpiCommand):
        return row.command.fit(typed, present) if isinstance(typed, TypedUnit) else False
    if not isinstance(typed, str):
        return False
    matched = match(row.command, typed, 0, present)
    if isinstance(matched, Match) and matched.end == len(typed):
        return matched.found
    first, *others = row.command.parts
    is_begun = isinstance(first, Literal) and len(typed) > len(first.text) > 1
    return is_begun and matched != 0 and any(isinstance(part, Slot) for part in others)


def prefixed(table: InstrumentTable, line: str, look: Look) -> str | None:
    """Rest of a line that is for this instrument; None: it is another's."""
    if table.prefix is None:
        return line
    matched = match(table.prefix, line, 0, _present(look))
    return line[matched.end :] if isinstance(matched, Match) else None


def _present(look: Look) -> Callable[[Slot, Found], Value | None]:
    def present(slot: Slot, found: Found) -> Value | None:
        if not slot.which:
            value = look(slot.name, None)
        else:
            number = int(slot.which) if slot.which.isdecimal() else found.get(slot.which)
            if not isinstance(number, int | float):
                return None
            value = look(slot.name, int(number))
        if isinstance(value, str) and value in slot.kind.words:
            return float(slot.kind.words.index(value))
        return value

    return present


def resolved(table: InstrumentTable, row: DialogueRow, found: Found) -> tuple[dict[str, Value], Given, str]:
    """Values of a command by names of its own, variables to be set, and the kind of error."""
    local: dict[str, Value] = {}
    given: Given = []
    takes = row.takes or {}
    for slot in slots_of(row):
        if slot.name not in found or slot.is_given:
            continue
        variable = takes.get(slot.name) or table.variables[slot.name]
        value = _of_word(variable, found[slot.name])
        taken = variable.taken(value)
        if taken is None:
            return {}, [], OUT_OF_RANGE
        if slot.name in takes:
            local[slot.name] = (
                variable.words[int(taken)] if variable.words and isinstance(taken, float) else taken
            )
            continue
        number = None
        if slot.which:
            which = float(slot.which) if slot.which.isdecimal() else found.get(slot.which, 0.0)
            number = int(which) if isinstance(which, float) else 0
            if not 1 <= number <= variable.many:
                return {}, [], OUT_OF_RANGE
        given.append((slot.name, number, taken))
    for name, value in found.items():
        if name in takes and name not in local:  # the number at the end of a header's word
            if takes[name].taken(value) is None:
                return {}, [], OUT_OF_RANGE
            local[name] = value
    return local, given, ""


def slots_of(row: DialogueRow) -> list[Slot]:
    """Places for values of a command."""
    patterns: tuple[Pattern, ...] = (
        row.command.arguments if isinstance(row.command, ScpiCommand) else (row.command,)
    )
    return [slot for pattern in patterns for slot in pattern.slots()]


def _of_word(variable: Variable, value: Value) -> Value:
    """Number that one of SCPI's words for limits means."""
    if variable.kind not in ("number", "whole") or not isinstance(value, str):
        return value
    return {LIMITS[0]: variable.low, LIMITS[1]: variable.high}.get(value, variable.start)
