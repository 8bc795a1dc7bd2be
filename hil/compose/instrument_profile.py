"""Profile of boards that need no ``board.py``: their program is a table of commands and answers."""

from functools import partial

from hil.instruments.instrument import Instrument
from hil.instruments.instrument_table import InstrumentTable
from hil.vocab.profile import Example, Profile, UartSpec


def instrument_profile(uart: str, table: InstrumentTable) -> Profile:
    """Profile of a board with a serial interface of this name, and a table."""
    return Profile(
        firmware=partial(Instrument, table=table),
        uarts={uart: UartSpec(about="commands and answers")},
        shown_first=("at_ns", *table.shown),
        examples=tuple(
            Example(types=e.types, answer=e.answer, within_ms=e.within_ms) for e in table.examples
        ),
    )
