"""Notes to the user on what a program does wrong, or is done to it: the one table of their words.

A processor notes each once from a reset on.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

from hil.sketch.elf_file import Symbol
from hil.sketch.function_names import Functions


class ProgramNote(IntEnum):
    """Kind of a note, as the processor numbers them (``enum avr_note``)."""

    ILLEGAL = 1
    STACK = 2
    ASLEEP = 3
    OVERRUN = 4
    WATCHDOG_LOOP = 5


class _Words(NamedTuple):
    """Words of a note. ``text``: {value} is what it is about, {where} the function with a word before it, or
    nothing; ``is_at_value``: the value is the address of the function's instruction."""

    topic: str
    text: str
    is_at_value: bool = False


_WORDS = {
    ProgramNote.ILLEGAL: _Words(
        "illegal opcode",
        "at 0x{value:04X}{where} stands an opcode that this chip does not have; it is passed over: is the"
        " program whole, and built for an ATmega328P?",
        is_at_value=True,
    ),
    ProgramNote.STACK: _Words(
        "stack",
        "the stack has come down to 0x{value:04X}{where}, into variables or the heap, and overwrites them:"
        " put less on it, or less into SRAM",
    ),
    ProgramNote.ASLEEP: _Words(
        "asleep",
        "the program sleeps{where}, and nothing but a reset can wake it: no interrupt that could is enabled",
    ),
    ProgramNote.OVERRUN: _Words(
        "UART overrun",
        "a byte that came at RX was lost: the program did not read the one before in time{where}; are"
        " interrupts off for long?",
    ),
    ProgramNote.WATCHDOG_LOOP: _Words(
        "watchdog",
        "the watchdog resets the program again and again{where}: after it has reset the chip it stays on, at"
        " 16 ms; wdt_disable() has to come first in setup()",
    ),
}
_NOTES_OF_EVENT = 256


def program_note(value: float, program_counter: int, symbols: Sequence[Symbol] = ()) -> tuple[str, str]:
    """Topic and words of an event ``program_note``, whose value has the kind and what it is about."""
    about, number = divmod(int(value), _NOTES_OF_EVENT)
    words = _WORDS[ProgramNote(number)]
    function = Functions(symbols).name_at(about if words.is_at_value else program_counter)
    where = f", in {function}" if function else ""
    return words.topic, words.text.format(value=about, where=where)
