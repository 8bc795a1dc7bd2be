"""Table of an instrument, made of ``dialogue`` in a ``profile.yaml``; findings of all that is wrong there."""

import re
from collections.abc import Iterator, Mapping

from hil.config.dialogue_model import CommandInfo, DialogueInfo
from hil.config.dialogue_texts import DialogueTexts
from hil.config.dialogue_usual import usual_rows
from hil.config.dialogue_variables import made_parameter, made_variable, variable_findings
from hil.config.document import Finding, KeyPath
from hil.instruments.check_sums import CheckSum
from hil.instruments.command_cuts import Cuts
from hil.instruments.instrument_table import (
    BAD_VALUE,
    OUT_OF_RANGE,
    OVERFLOW,
    UNKNOWN,
    WRONG_STATE,
    WRONG_VALUES,
    AssignedValue,
    DialogueRow,
    Followed,
    InstrumentTable,
    TimedMessage,
    TypedExample,
    Variable,
)
from hil.instruments.patterns import Pattern, Slot, SlotKind, read_pattern
from hil.instruments.scpi import ScpiCommand, read_command
from hil.instruments.scpi_status import ERROR
from hil.instruments.table_expressions import Expression, Meaning, in_order, loop_in
from hil.vocab.near_words import meant
from hil.vocab.time import NS_PER_MS

DIALOGUE = "dialogue"
ENDS = {"CR": "\r", "LF": "\n", "CRLF": "\r\n"}
NO_ERROR = "none"
_WRONG_VALUES = (
    '-109,"Missing parameter"',
    '-108,"Parameter not allowed"',
    '-131,"Invalid suffix"',
    '-224,"Illegal parameter value"',
)
SCPI_ERRORS = {
    UNKNOWN: '-113,"Undefined header"',
    BAD_VALUE: '-104,"Data type error"',
    **dict(zip(WRONG_VALUES, _WRONG_VALUES, strict=True)),
    OUT_OF_RANGE: '-222,"Data out of range"',
    WRONG_STATE: '-221,"Settings conflict"',
    OVERFLOW: '-350,"Queue overflow"',
    NO_ERROR: '0,"No error"',
}
"""Errors. Source: SCPI 1999, volume 2, 21.8."""
_SHOWN = 4
_INDEX = re.compile(r"\[([A-Za-z_][A-Za-z0-9_]*)\]")
_TARGET = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)(?:\[(.*)\])?")


class TableReader(DialogueTexts):
    """Reader of one table, of the board of a name; what is wrong is noted, and the rest read all the same.
    ``table`` reads it.

    Long because each part of a table is one more short method here.
    """

    def __init__(self, info: DialogueInfo, name: str) -> None:
        self._info, self._name = info, name
        self._variables = {name: made_variable(name, each) for name, each in info.variables.items()}
        super().__init__(info.encoding, dict(self._variables))
        self.rows: dict[int, DialogueRow] = {}
        """Rows that could be read, by their numbers in the list of commands."""

    def table(self) -> InstrumentTable:
        """Read all of it."""
        info = self._info
        for name, each in info.variables.items():
            self.findings += variable_findings((DIALOGUE, "variables", name), name, each)
        self._add_formulas()
        for index, command in enumerate(info.commands):
            if row := self._row((DIALOGUE, "commands", index), command):
                self.rows[index] = row
        given = {key: text for key, text in info.errors if text is not None}
        errors = {key: self._bytes((DIALOGUE, "errors", key), text) for key, text in given.items()}
        if info.scpi:
            wrong = dict.fromkeys(WRONG_VALUES, errors[BAD_VALUE]) if BAD_VALUE in errors else {}
            errors = SCPI_ERRORS | wrong | errors
        elif UNKNOWN in errors:
            errors.setdefault(BAD_VALUE, errors[UNKNOWN])
        usual = usual_rows(self._name, _ns(info.answer_after_ms)) if info.scpi else ()
        return InstrumentTable(
            self._variables,
            (*self.rows.values(), *usual),
            self._cuts(),
            answer_end=self._end(
                (DIALOGUE, "answers_end_with"), info.answers_end_with, "" if self._is_hex else "CRLF"
            ),
            echoes=info.echo,
            is_scpi=info.scpi,
            prefix=self._prefix(),
            answer_prefix=self._template((DIALOGUE, "answer_prefix"), info.answer_prefix, self._known),
            check_sum=CheckSum(info.checksum.kind, info.checksum.form == "hex") if info.checksum else None,
            errors=errors,
            queue=info.queue if info.scpi else 0,
            no_error=errors.get(NO_ERROR, ""),
            messages=tuple(self._messages()),
            greeting=self._template((DIALOGUE, "greeting"), info.greeting, self._known),
            ready_ns=_ns(info.ready_after_ms),
            update_ns=_ns(info.update_ms),
            formulas=self._order(),
            examples=tuple(self._examples()),
            shown=self._shown(),
        )

    def _add_formulas(self) -> None:
        for name, info in self._info.variables.items():
            path: KeyPath = (DIALOGUE, "variables", name)
            known = self._known | ({"n": Variable("n")} if info.many else {})
            if info.computed is not None:
                formula = self._expression((*path, "computed"), info.computed, known)
                self._check_kind((*path, "computed"), self._variables[name], formula)
                self._variables[name] = self._variables[name]._replace(formula=formula)
            if info.follows is not None:
                wanted = info.follows
                target = self._expression((*path, "follows", "target"), wanted.target, known)
                self._check_kind((*path, "follows", "target"), self._variables[name], target)
                times = [
                    None if text is None else self._expression((*path, "follows", key), text, known)
                    for key, text in (
                        ("time_constant_s", wanted.time_constant_s),
                        ("rate_per_s", wanted.rate_per_s),
                    )
                ]
                if target:
                    follows = Followed(target, *times)
                    self._variables[name] = self._variables[name]._replace(follows=follows)

    def _check_kind(self, path: KeyPath, variable: Variable, value: Expression | None) -> None:
        """Note a value that a variable cannot have."""
        if value is None:
            return
        if value.is_text != (variable.kind == "text" or (variable.is_text and value.is_text)):
            kinds = ["a number", "a text"]
            message = f"{variable.name} is {kinds[variable.is_text]}, and this is {kinds[value.is_text]}"
            self._find(path, message, "let both be of one kind")
        elif value.unit and variable.unit and value.unit != variable.unit:
            remedy = f"multiply by the factor, as in 1000 * {sorted(value.names)[0]}"
            self._find(path, f"{variable.name} is in {variable.unit}, and this in {value.unit}", remedy)

    def _order(self) -> tuple[str, ...]:
        """Names of computed variables in the order in which they are computed."""
        reads = {name: each.formula.names for name, each in self._variables.items() if each.formula}
        if loop := loop_in(reads):
            message = f"these are computed from each other: {' <- '.join((*loop, loop[0]))}"
            self._find(
                (DIALOGUE, "variables", loop[0], "computed"), message, "let one of them follow, or be set"
            )
            return ()
        return in_order(reads)

    def _row(self, path: KeyPath, info: CommandInfo) -> DialogueRow | None:
        takes = {name: made_parameter(name, each) for name, each in info.takes.items()}
        for name, each in info.takes.items():
            self.findings += variable_findings((*path, "takes", name), name, each)
            if name in self._variables:
                self._find((*path, "takes", name), "a variable has this name", "give it another", at_key=True)
        asks = (*path, "asks")
        takes |= self._numbers(info, takes)
        command = self._command(asks, info.asks, takes)
        known = self._known | takes
        said = [info.answers] if isinstance(info.answers, str) else info.answers or []
        places = (
            [(*path, "answers")]
            if isinstance(info.answers, str)
            else [(*path, "answers", i) for i in range(len(said))]
        )
        with_error = known | ({ERROR: Variable(ERROR, "text")} if self._info.scpi else {})
        answers = [self._template(at, text, with_error) for at, text in zip(places, said, strict=True)]
        when = self._condition((*path, "when"), info.when, known)
        sets = [self._setting((*path, "sets", name), name, text, known) for name, text in info.sets.items()]
        if command is None:
            return None
        takes_ms = self._info.answer_after_ms if info.takes_ms is None else info.takes_ms
        return DialogueRow(
            command,
            when,
            tuple(each for each in sets if each),
            tuple(each for each in answers if each),
            _ns(takes_ms),
            takes,
            info.clears_errors,
        )

    def _numbers(self, info: CommandInfo, takes: Mapping[str, Variable]) -> dict[str, Variable]:
        """Values of a command that say which of several variables is meant, as ``n`` of ``relay[n]``."""
        said = [info.answers] if isinstance(info.answers, str) else info.answers or []
        text = " ".join((info.asks, *said, *info.sets, *map(str, info.sets.values())))
        found = {}
        for name in _INDEX.findall(text):
            if name not in takes and name not in self._variables and f"{{{name}" in info.asks:
                many = (each.many for each in self._variables.values() if f"{each.name}[{name}]" in text)
                found[name] = Variable(name, "whole", low=1, high=min(many, default=1))
        return found

    def _command(
        self, path: KeyPath, text: str, takes: Mapping[str, Variable]
    ) -> Pattern | ScpiCommand | None:
        def kind_of(name: str) -> SlotKind | None:
            each = takes.get(name) or self._variables.get(name)
            return SlotKind(each.kind, each.words) if each else None

        if not text.strip():
            self._find(path, "this pattern is empty", "write what is typed")
            return None
        said = self._bytes(path, text)
        command: Pattern | ScpiCommand | None
        if self._info.scpi:
            units = {name: each.unit for name, each in (self._variables | dict(takes)).items()}
            command = self._try(path, lambda: read_command(said, kind_of, units))
        else:
            has_cases = not self._info.ignore_case
            command = self._try(
                path, lambda: read_pattern(said, kind_of, has_cases=has_cases, is_hex=self._is_hex)
            )
        if command:
            patterns = command.arguments if isinstance(command, ScpiCommand) else (command,)
            slots = [slot for pattern in patterns for slot in pattern.slots()]
            header = command.headers[0] if isinstance(command, ScpiCommand) else ()
            names = [slot.name for slot in slots] + [word.suffix for word in header]
            self._check_slots(path, slots, names, takes)
        return command

    def _check_slots(
        self, path: KeyPath, slots: list[Slot], names: list[str], takes: Mapping[str, Variable]
    ) -> None:
        for slot in slots:
            if slot.name in takes:
                continue
            variable = self._variables[slot.name]
            if bool(variable.many) != bool(slot.which):
                which = (
                    f"write which of them, as in {{{slot.name}[n]}}"
                    if variable.many
                    else f"write {{{slot.name}}}"
                )
                self._find(path, f"there is {'more than ' * bool(variable.many)}one {slot.name}", which)
            elif slot.which.isdecimal() and not 1 <= int(slot.which) <= variable.many:
                self._find(path, f"there is no {slot.name}[{slot.which}]", f"write 1 to {variable.many}")
            elif slot.which and not slot.which.isdecimal() and slot.which not in names:
                remedy = f"write {{{slot.which}}}, too, where its number is typed"
                self._find(path, f"nothing says which {slot.name} it is", remedy)
            if not slot.is_given and names.count(slot.name) > 1:
                self._find(
                    path, f"{slot.name} is set twice", "write a value of the command's own, and takes: for it"
                )
            elif not slot.is_given:
                self._check_settable(path, slot.name)

    def _check_settable(self, path: KeyPath, name: str) -> None:
        variable, at_key = self._variables[name], "sets" in path
        if variable.formula or self._info.variables[name].computed is not None:
            self._find(path, f"{name} is computed", "set what it is computed from", at_key=at_key)
        elif variable.is_input:
            self._find(
                path, f"{name} is an input", "commands read it; `hil set` and tests set it", at_key=at_key
            )

    def _setting(
        self, path: KeyPath, target: str, text: str | float, known: dict[str, Meaning]
    ) -> AssignedValue | None:
        value = self._expression(path, text, known)
        found = _TARGET.fullmatch(target.strip())
        if found is None or found[1] not in self._variables:
            name = found[1] if found else target
            self.findings.append(
                Finding(
                    path, f'there is no variable "{name}"', meant(name, list(self._variables)), at_key=True
                )
            )
            return None
        variable = self._variables[found[1]]
        if bool(variable.many) != (found[2] is not None):
            which = f"{variable.name}[1]" if variable.many else variable.name
            self._find(path, f"{target} does not stand so here", f"write it as {which}", at_key=True)
            return None
        self._check_settable(path, found[1])
        self._check_kind(path, variable, value)
        index = None if found[2] is None else self._expression(path, found[2], known)
        return AssignedValue(found[1], index, value) if value else None

    def _messages(self) -> Iterator[TimedMessage]:
        for index, info in enumerate(self._info.messages):
            path: KeyPath = (DIALOGUE, "messages", index)
            says = self._template((*path, "says"), info.says or " ", self._known)
            when = self._condition((*path, "when"), info.when, self._known)
            if says:
                yield TimedMessage(says, _ns(info.every_ms), when)

    def _end(self, path: KeyPath, text: str | None, usual: str) -> str:
        said = usual if text is None else text
        return ENDS.get(said) or self._bytes(path, said)

    def _cuts(self) -> Cuts:
        info = self._info
        usual = [] if info.command_bytes or info.ends_after_ms or self._is_hex else ["CR", "LF"]
        ends = usual if info.ends_with is None else info.ends_with
        path: KeyPath = (DIALOGUE, "ends_with")
        if "" in ends:
            self._find((*path, ends.index("")), "this line end is empty", "write CR, LF, CRLF or a text")
        if not ends and not info.command_bytes and not info.ends_after_ms:
            remedy = "write ends_with:, command_bytes: or ends_after_ms:"
            self._find((DIALOGUE,), "nothing says where a command ends", remedy, at_key=True)
        begins = self._bytes((DIALOGUE, "begins_with"), info.begins_with)
        if self._is_hex and begins:
            begins = self._digits((DIALOGUE, "begins_with"), begins)
        return Cuts(
            tuple(filter(None, (self._end((*path, index), each, "") for index, each in enumerate(ends)))),
            info.command_bytes,
            begins,
            _ns(info.ends_after_ms),
            info.longest,
        )

    def _prefix(self) -> Pattern | None:
        path: KeyPath = (DIALOGUE, "prefix")
        if not self._info.prefix:
            return None
        said = self._bytes(path, self._info.prefix)

        def kind_of(name: str) -> SlotKind | None:
            each = self._variables.get(name)
            return SlotKind(each.kind, each.words) if each else None

        found = self._try(path, lambda: read_pattern(said, kind_of, is_hex=self._is_hex))
        if found and any(not slot.is_given for slot in found.slots()):
            self._find(path, "a prefix sets nothing", "write the present value, as in {=address:02d}")
        return found

    def _examples(self) -> Iterator[TypedExample]:
        end = next(iter(self._cuts().ends), "")
        for index, info in enumerate(self._info.examples):
            path: KeyPath = (DIALOGUE, "examples", index)
            said = []
            for key, text in (("types", info.types), ("answer", info.answer)):
                plain = self._bytes((*path, key), text)
                if self._is_hex:
                    plain = self._digits((*path, key), plain)
                said.append(plain)
            yield TypedExample((said[0] + end).encode("latin-1"), said[1].encode("latin-1"), info.within_ms)

    def _shown(self) -> tuple[str, ...]:
        fields = [
            name for name, each in self._info.variables.items() if each.type != "text" and not each.many
        ]
        wanted = self._info.shown_first
        for index, name in enumerate(wanted or []):
            if name not in fields:
                message, remedy = f'there is no variable "{name}" with a number', meant(name, fields)
                self._find((DIALOGUE, "shown_first", index), message, remedy)
        return tuple(fields[:_SHOWN] if wanted is None else wanted)


def _ns(ms: float) -> int:
    return round(ms * NS_PER_MS)
