"""Present values of an instrument's variables, and how they go on by themselves as time passes."""

import json
import math
from collections.abc import Iterator, MutableMapping

from hil.instruments.instrument_table import OUT_OF_RANGE, DialogueRow, InstrumentTable, Variable, field_name
from hil.instruments.scpi_status import NAMES, ScpiStatus
from hil.instruments.table_expressions import Value
from hil.vocab.time import NS_PER_S

Given = dict[str, Value]
"""Values by the names of variables or of what a command takes."""


class PresentValues:
    """Values by variable and number: numbers are fields of the board, which all that look at it see; texts
    are here, and ``status`` has its own names."""

    def __init__(
        self, table: InstrumentTable, fields: MutableMapping[str, float], status: ScpiStatus
    ) -> None:
        self._table, self._fields, self._status = table, fields, status
        self._texts = {
            (name, number): str(each.start)
            for name, each in table.variables.items()
            if each.kind == "text"
            for number in each.numbers
        }
        self._names = {
            (name, number): field_name(name, number)
            for name, each in table.variables.items()
            for number in each.numbers
        }
        self._starts: dict[tuple[str, int | None], Value] = {}
        self._given: Given = {}
        self._slow = [each for each in table.variables.values() if each.follows]
        self._at_ns = 0
        self.is_slow = bool(self._slow or table.formulas)
        """True if values go on by themselves."""

    def look(self, name: str, number: int | None = None) -> Value:
        """Value of a variable now, a choice's as its word; what a command was given goes before."""
        if number is None and name in self._given:
            return self._given[name]
        if name in NAMES:
            return self._status.look(name)
        if (name, number) in self._texts:
            return self._texts[name, number]
        value = float(self._fields[self._names[name, number]])
        words = self._table.variables[name].words
        return words[int(value)] if words else value

    def raw(self, name: str, number: int | None) -> Value:
        """Value as it is kept: a choice's as a number."""
        if (name, number) in self._texts:
            return self._texts[name, number]
        return float(self._fields[self._names[name, number]])

    def knows(self, given: Given) -> None:
        """Let expressions see what a command was given, until ``forget``."""
        self._given = given

    def forget(self) -> None:
        """Forget what a command was given."""
        self._given = {}

    def put(self, name: str, number: int | None, value: Value) -> bool:
        """Set a variable; False: that is out of its range, and nothing was set."""
        taken = self._table.variables[name].taken(value)
        if taken is None:
            return False
        self._store(name, number, taken)
        return True

    def carry_out(self, row: DialogueRow, given: list[tuple[str, int | None, Value]]) -> tuple[str, bool]:
        """Set what a command sets; answers the kind of error, if any, and whether values changed that stay
        without power."""
        problem, is_kept = "", False
        for name, number, value in given:
            self.put(name, number, value)
            is_kept |= self._table.variables[name].is_kept
        for setting in row.sets:
            number = None
            if setting.which is not None:
                which = setting.which.value(self.look)
                number = int(which) if isinstance(which, float) else 1
                number = min(max(number, 1), self._table.variables[setting.name].many)
            if setting.name in NAMES:
                self._status.put(setting.name, _float(setting.value.value(self.look)))
                continue
            if not self.put(setting.name, number, setting.value.value(self.look)):
                problem = OUT_OF_RANGE
                break
            is_kept |= self._table.variables[setting.name].is_kept
        self._compute()
        return problem, is_kept

    def advance(self, now_ns: int) -> None:
        """Let slow values go on until now, and compute what follows from them."""
        past_s, self._at_ns = (now_ns - self._at_ns) / NS_PER_S, now_ns
        if past_s > 0:
            for each in self._slow:
                self._go_on(each, past_s)
        self._compute()

    def restore(self, kept: bytes, now_ns: int) -> None:
        """Begin after power-up, with what was kept."""
        self._at_ns = now_ns
        self._starts = {name: self.raw(*name) for name in self._reset_names()}
        try:
            said = json.loads(kept) if kept else {}
        except ValueError:
            said = {}  # the memory is another board's, or was damaged: as after the first power-up
        for name, number in self._kept_names():
            value = said.get(self._names[name, number]) if isinstance(said, dict) else None
            if isinstance(value, str | int | float):
                self.put(name, number, value)
        self._compute()

    def reset(self) -> None:
        """Give the variables that commands set the values of power-up, but those that stay without power."""
        for (name, number), value in self._starts.items():
            self._store(name, number, value)
        self._compute()

    def _reset_names(self) -> Iterator[tuple[str, int | None]]:
        for name, each in self._table.variables.items():
            if not (each.is_kept or each.is_input or each.formula or each.follows):
                yield from ((name, number) for number in each.numbers)

    def kept(self) -> dict[str, Value]:
        """Values that stay without power, by their names."""
        return {self._names[name, number]: self.raw(name, number) for name, number in self._kept_names()}

    def _kept_names(self) -> Iterator[tuple[str, int | None]]:
        for name, each in self._table.variables.items():
            if each.is_kept:
                yield from ((name, number) for number in each.numbers)

    def _go_on(self, variable: Variable, past_s: float) -> None:
        follows = variable.follows
        assert follows is not None
        given = self._given
        for number in variable.numbers:
            self._given = given | ({"n": float(number)} if number else {})
            value = float(self._fields[self._names[variable.name, number]])
            target = _float(follows.target.value(self.look))
            if follows.time_constant_s is not None:
                constant_s = _float(follows.time_constant_s.value(self.look))
                left = math.exp(-past_s / constant_s) if constant_s > 0 else 0.0
                value = target + (value - target) * left
            elif follows.rate_per_s is not None:
                most = abs(_float(follows.rate_per_s.value(self.look))) * past_s
                value += min(max(target - value, -most), most)
            self._store_within(variable, number, value)
        self._given = given

    def _compute(self) -> None:
        for name in self._table.formulas:
            variable = self._table.variables[name]
            assert variable.formula is not None
            given = self._given
            for number in variable.numbers:
                self._given = given | ({"n": float(number)} if number else {})
                value = variable.formula.value(self.look)
                if variable.kind in ("text", "choice"):
                    self.put(name, number, value)
                else:
                    self._store_within(variable, number, _float(value))
            self._given = given

    def _store_within(self, variable: Variable, number: int | None, value: float) -> None:
        value = min(max(value, variable.low), variable.high)
        self._store(variable.name, number, value if variable.kind == "number" else float(round(value)))

    def _store(self, name: str, number: int | None, value: Value) -> None:
        if (name, number) in self._texts:
            self._texts[name, number] = str(value)
            return
        field = self._names[name, number]
        if self._fields[field] != value:
            self._fields[field] = _float(value)


def _float(value: Value) -> float:
    return float(value) if isinstance(value, float | int) else 0.0
