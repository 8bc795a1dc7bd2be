"""Commands that all tables with SCPI's forms have, after those of the table: the common ones of IEEE 488.2,
and the queue of errors."""

from collections.abc import Iterator
from functools import cache

from hil.instruments.instrument_table import AssignedValue, DialogueRow, Variable
from hil.instruments.patterns import NUMBER, SlotKind
from hil.instruments.scpi import ScpiCommand, read_command
from hil.instruments.scpi_status import COMPLETE, ERROR, EVENTS, EVENTS_ENABLED, REQUESTS_ENABLED, STATUS
from hil.instruments.table_expressions import Expression, Value
from hil.instruments.templates import Blank, Template

_NUMBER = "n"
_ENABLED = Variable(_NUMBER, NUMBER, low=0, high=255, step=1)
_QUERIES = (
    ("SYSTem:ERRor[:NEXT]?", ERROR),
    ("*ESR?", EVENTS),
    ("*ESE?", EVENTS_ENABLED),
    ("*STB?", STATUS),
    ("*SRE?", REQUESTS_ENABLED),
)
_FIXED = (("*OPC?", "1"), ("*TST?", "0"), ("SYSTem:VERSion?", "1999.0"))
"""Commands that always have the same answer: all is done, the test of itself was passed, the year of SCPI."""


def usual_rows(name: str, takes_ns: int) -> Iterator[DialogueRow]:
    """Rows, in their order. ``name``: the board's, which ``*IDN?`` answers; ``takes_ns``: what each takes."""
    for asks, register in _QUERIES:
        answer = Template(register, (Blank(_look(register), _written),), register == ERROR)
        yield DialogueRow(_command(asks), answers=(answer,), takes_ns=takes_ns)
    for asks, text in (("*IDN?", f"hil,{name},0,0"), *_FIXED):
        yield DialogueRow(_command(asks), answers=(Template(text, (text,)),), takes_ns=takes_ns)
    for register in (EVENTS_ENABLED, REQUESTS_ENABLED):
        sets = (AssignedValue(register, None, _look(_NUMBER)),)
        command = _command(f"{register} {{{_NUMBER}}}")
        yield DialogueRow(command, sets=sets, takes_ns=takes_ns, takes={_NUMBER: _ENABLED})
    complete = Expression("", False, "", frozenset(), lambda look: float(COMPLETE))
    yield DialogueRow(_command("*OPC"), sets=(AssignedValue(EVENTS, None, complete),), takes_ns=takes_ns)
    yield DialogueRow(_command("*WAI"), takes_ns=takes_ns)
    yield DialogueRow(_command("*CLS"), takes_ns=takes_ns, clears_errors=True)
    yield DialogueRow(_command("*RST"), takes_ns=takes_ns, resets=True)


@cache
def _command(asks: str) -> ScpiCommand:
    return read_command(asks, lambda name: SlotKind(NUMBER), {})


def _look(name: str) -> Expression:
    return Expression(name, name == ERROR, "", frozenset({name}), lambda look: look(name, None))


def _written(value: Value) -> str:
    return value if isinstance(value, str) else str(int(value))
