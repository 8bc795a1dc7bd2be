"""Checks of commands by value and of states: words that are known, that fit, and that do not contradict."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

from bridges.modbus.maps.map_part_rows import PartRow, blocks_of
from bridges.modbus.maps.map_row_models import ByValueText, ModeText, StateRowText
from bridges.modbus.registers.drive_map import lowest_bit
from bridges.modbus.registers.map_parts import COMMANDS_BY_WORD, CONDITIONS
from hil.config.document import Finding, KeyPath
from hil.config.explain import no_such

_MOVE = "move_"
_STARTS = ("start", "start_absolute", "start_relative", "start_directed", "run", "home", "search_home")
_CONTRADICT = (
    frozenset({"enable", "disable"}),
    frozenset({"forward", "reverse"}),
    frozenset({"stop", "halt"}),
    frozenset({"store", "restore"}),
    *(frozenset({start, stop}) for start in _STARTS for stop in ("stop", "halt", "disable")),
    *(frozenset(pair) for pair in combinations(_STARTS, 2)),
)
_NEEDS = {
    "start_absolute": ("set_point_deg",),
    "start_relative": ("set_point_deg",),
    "start_directed": ("set_point_deg",),
    "run": ("set_velocity_rpm", "run_velocity_rpm"),
    "start": ("set_point_deg", "set_velocity_rpm", "run_velocity_rpm"),
}
"""Values of which a command needs one."""
_OPPOSITES = (("enabled", "disabled"), ("moving", "standing"), ("fault", "sound"))
"""Conditions of which one always holds."""
_IMPLIED = {
    "arrived": ("enabled", "standing"),
    "at_speed": ("moving",),
    "running": ("enabled",),
    "ready": ("sound", "disabled"),
}
"""Conditions that hold whenever one does."""


def command_findings(given: Mapping[Any, Any], rows: Sequence[PartRow]) -> Iterator[Finding]:
    """Findings of commands: of each register, of blocks, and of conditions of refusals."""
    values = {str(key) for key in given}
    values |= {row.name for row in rows if row.kind == "value"}
    moves = given.get("moves")
    count = moves.get("count", 1) if isinstance(moves, dict) else 0
    count = count if isinstance(count, int) else 0
    stored = any(getattr(row.text, "stored", "") == "by_command" for row in rows)
    for row in rows:
        if row.move:
            continue
        if isinstance(row.text, ByValueText):
            yield from _values_findings(row, row.text, values, count, stored=stored)
        elif isinstance(row.text, ModeText):
            yield from _number_findings(row, row.text.values)
        conditions: Collection[str] = getattr(row.text, "refuse_while", {})
        for condition in conditions:
            yield from _condition_findings((*row.path, "refuse_while", condition), condition)
    for name, block in blocks_of(given).items():
        for key, words in (("then", block.words), ("at_zero_speed", block.at_zero_speed)):
            yield from _words_findings(
                ("blocks", name, key), f"the block {name}", words, values, count, stored=stored
            )
    yield from _standard_findings(rows)


def _standard_findings(rows: Sequence[PartRow]) -> Iterator[Finding]:
    """Findings of a second control word: there is one state machine."""
    words = [row for row in rows if isinstance(row.text, ByValueText) and row.text.standard]
    for row in words[1:]:
        what = f"{words[0].name} is the control word of {words[0].text.standard} already"
        yield Finding((*row.path, "standard"), what, "keep one of the two", at_key=True)


def state_findings(row: PartRow, text: StateRowText) -> Iterator[Finding]:
    """Findings of a register that tells states."""
    path = row.path
    if text.standard and text.values:
        yield Finding((*path, "values"), f"{text.standard} has its own states", "remove one of the two", True)
    if not text.standard and not text.values:
        yield Finding(path, "no state is given", "add values, as in values: {moving: 1}")
    for condition in text.values:
        yield from _condition_findings((*path, "values", condition), condition)
    before: list[str] = []
    for condition in text.values:
        if hides := _hides(before, condition):
            what = f"{condition} never counts: where it holds, {hides} does, and stands before it"
            yield Finding((*path, "values", condition), what, "put it before, or remove it", at_key=True)
        before.append(condition)
    yield from _number_findings(row, {**text.values, "": text.otherwise}, is_state=True)


def _hides(before: Collection[str], condition: str) -> str:
    """Conditions among those before one that hold whenever it does, in words; empty: there are none."""
    for pair in _OPPOSITES:
        if set(pair) <= set(before):
            return f"{pair[0]} or {pair[1]}"
    return next((each for each in before if each in _IMPLIED.get(condition, ())), "")


def _condition_findings(path: KeyPath, condition: str) -> Iterator[Finding]:
    if condition not in CONDITIONS:
        wrong = no_such(path, "condition", condition, CONDITIONS)
        yield Finding(path, wrong.message, wrong.remedy, at_key=True)


def _values_findings(
    row: PartRow, text: ByValueText, values: Collection[str], moves: int, *, stored: bool
) -> Iterator[Finding]:
    path = row.path
    if text.standard and text.values:
        yield Finding(
            (*path, "values"), f"{text.standard} has its own commands", "remove one of the two", True
        )
    if not text.standard and not text.values:
        yield Finding(path, "no command is given", "add values, as in values: {stop: 1}")
    if text.scale != 1 or text.type == "text":
        key = "scale" if text.scale != 1 else "type"
        yield Finding((*path, key), "a command is a whole number", "remove it", at_key=True)
    yield from _number_findings(row, text.values)
    for given in text.values:
        yield from _words_findings(
            (*path, "values", given), "it", given.split("+"), values, moves, stored=stored
        )


def _words_findings(
    path: KeyPath, what: str, words: Sequence[str], values: Collection[str], moves: int, *, stored: bool
) -> Iterator[Finding]:
    for word in words:
        number = word.removeprefix(_MOVE)
        if word.startswith(_MOVE) and number.isdecimal():
            if int(number) >= moves:
                said = f"there is no move {number}; there are {moves}"
                yield Finding(path, said, "add moves with a larger count" if moves else "add moves")
        elif word not in COMMANDS_BY_WORD:
            wrong = no_such(path, "command", word, [*COMMANDS_BY_WORD, *([f"{_MOVE}0"] if moves else [])])
            yield Finding(path, wrong.message, wrong.remedy)
        elif word in _NEEDS and not any(need in values for need in _NEEDS[word]):
            needs = " or ".join(_NEEDS[word])
            yield Finding(path, f"{word} needs {needs}, which this map has not", f"add {_NEEDS[word][0]}")
        elif word == "store" and not stored:
            yield Finding(path, "no cell is stored by a command", "add stored: by_command to those that are")
    for pair in _CONTRADICT:
        if pair <= set(words):
            first, second = (word for word in words if word in pair)
            yield Finding(path, f"{what} is {first} and {second} at once", "leave one of them out")
    starts = [word for word in words if word.startswith(_MOVE) or word in _STARTS]
    if len(starts) > 1 and any(word.startswith(_MOVE) for word in starts):
        yield Finding(path, f"{what} is {' and '.join(starts)} at once", "leave one of them out")


def _number_findings(
    row: PartRow, values: Mapping[Any, int | tuple[int, ...]], *, is_state: bool = False
) -> Iterator[Finding]:
    text = row.text
    bits = 1 if row.is_bit else 32 if text.type.endswith("32") else 16
    most = text.mask >> lowest_bit(text.mask) if text.mask is not None else (1 << bits) - 1
    taken: dict[int, str] = {}
    for word, given in values.items():
        path: KeyPath = (*row.path, "values", word) if word else (*row.path, "otherwise")
        for number in (given,) if isinstance(given, int) else given:
            if number > most:
                what = f"{number:X}h is not among the {most.bit_length()} bits that it has"
                yield Finding(path, what, "write the number of its bits alone, without a shift")
            elif not is_state and taken.setdefault(number, word) != word:
                what = f"{number:X}h is {taken[number]} already"
                yield Finding(path, what, "give each command numbers of its own")
