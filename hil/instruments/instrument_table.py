"""Table of an instrument: its variables, commands, messages, and the manners of its line."""

from collections.abc import Mapping
from typing import NamedTuple

from hil.instruments.check_sums import CheckSum
from hil.instruments.command_cuts import Cuts
from hil.instruments.patterns import CHOICE, NUMBER, TEXT, Pattern
from hil.instruments.scpi import ScpiCommand
from hil.instruments.table_expressions import Expression, Value
from hil.instruments.templates import Template
from hil.vocab.time import NS_PER_MS

UNKNOWN, BAD_VALUE, OUT_OF_RANGE, WRONG_STATE, OVERFLOW = (
    "unknown",
    "bad_value",
    "out_of_range",
    "wrong_state",
    "overflow",
)
"""Kinds of errors."""
MISSING_VALUE, EXTRA_VALUE, BAD_SUFFIX, BAD_WORD = "missing_value", "extra_value", "bad_suffix", "bad_word"
WRONG_VALUES = (MISSING_VALUE, EXTRA_VALUE, BAD_SUFFIX, BAD_WORD)
"""Kinds of a bad value in SCPI's forms."""


class Followed(NamedTuple):
    """Value that a variable goes after: with a time constant in s, or by at most so much a second."""

    target: Expression
    time_constant_s: Expression | None = None
    rate_per_s: Expression | None = None


class Variable(NamedTuple):
    """Variable of an instrument. ``many``: how many there are of the name, 0: one; ``words``: those of a
    choice; ``start``: its value at power-up, a text's text, else a number; ``formula``: what it always is."""

    name: str
    kind: str = NUMBER
    unit: str = ""
    many: int = 0
    low: float = 0.0
    high: float = 0.0
    step: float = 0.0
    words: tuple[str, ...] = ()
    start: Value = 0.0
    longest: int = 64
    is_kept: bool = False
    is_input: bool = False
    formula: Expression | None = None
    follows: Followed | None = None

    @property
    def is_text(self) -> bool:
        """True if expressions see a text: also of a choice, whose word they see."""
        return self.kind in (TEXT, CHOICE)

    @property
    def numbers(self) -> tuple[int | None, ...]:
        """Numbers of the variables of the name; None alone of one."""
        return tuple(range(1, self.many + 1)) or (None,)

    def taken(self, value: Value) -> Value | None:
        """Value as the variable has it, rounded to its step; None: it is out of its range."""
        if self.kind == TEXT:
            text = str(value)
            return text if len(text) <= self.longest else None
        if self.kind == CHOICE and isinstance(value, str):
            value = float(self.words.index(value)) if value in self.words else -1.0
        if not isinstance(value, float | int) or not self.low <= value <= self.high:
            return None
        if self.step:
            value = min(max(round(round(value / self.step) * self.step, 12), self.low), self.high)
        if self.kind != NUMBER and value != int(value):
            return None
        return float(value)


def field_name(name: str, number: int | None) -> str:
    """Name of the field of a variable, as in ``relay2``; the number stands before a unit: ``voltage2_V``."""
    if number is None:
        return name
    stem, _, unit = name.rpartition("_")
    return f"{stem}{number}_{unit}" if stem else f"{name}{number}"


class AssignedValue(NamedTuple):
    """Value that a command sets beside what it was given: a variable, and ``which`` of several."""

    name: str
    which: Expression | None
    value: Expression


class DialogueRow(NamedTuple):
    """Command: how it is written, when it is one, what it does, what it answers, and the time for that.
    ``takes``: values of its own, by name; ``clears_errors``: it clears the status, as ``*CLS`` does;
    ``resets``: it gives the variables the values of power-up first, as ``*RST`` does."""

    command: Pattern | ScpiCommand
    when: Expression | None = None
    sets: tuple[AssignedValue, ...] = ()
    answers: tuple[Template, ...] = ()
    takes_ns: int = 0
    takes: Mapping[str, Variable] | None = None
    clears_errors: bool = False
    resets: bool = False


class TimedMessage(NamedTuple):
    """Text that the instrument sends by itself."""

    says: Template
    every_ns: int
    when: Expression | None = None


class TypedExample(NamedTuple):
    """Exchange that ``hil profile check`` tries: bytes, and the time for the answer."""

    types: bytes
    answer: bytes
    within_ms: float


class InstrumentTable(NamedTuple):
    """Table of an instrument. ``errors``: text of each kind that is said; ``queue``: errors that wait to be
    asked for, 0: they are answered at once; ``prefix``, ``answer_prefix``: what each command and answer
    begins with; ``formulas``: names of computed variables in the order in which they are computed."""

    variables: Mapping[str, Variable]
    rows: tuple[DialogueRow, ...]
    cuts: Cuts
    answer_end: str = "\r\n"
    echoes: bool = False
    is_scpi: bool = False
    prefix: Pattern | None = None
    answer_prefix: Template | None = None
    check_sum: CheckSum | None = None
    errors: Mapping[str, str] | None = None
    queue: int = 0
    no_error: str = ""
    messages: tuple[TimedMessage, ...] = ()
    greeting: Template | None = None
    ready_ns: int = 0
    update_ns: int = 100 * NS_PER_MS
    formulas: tuple[str, ...] = ()
    examples: tuple[TypedExample, ...] = ()
    shown: tuple[str, ...] = ()
    title: str = ""
