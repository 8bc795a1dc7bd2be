"""Checks of the words of notes, and of functions' names."""

import pytest

from hil.sketch.elf_file import Symbol
from hil.sketch.function_names import Functions, source_name
from hil.sketch.program_notes import ProgramNote, program_note

SYMBOLS = [
    Symbol("_Z4waitv", 0x200, 0x10, "function"),
    Symbol("loop", 0x100, 0x20, "function"),
    Symbol("alias_of_loop", 0x100, 0x20, "function"),
    Symbol("__vector_16", 0x300, 0, "function"),
    Symbol("counter", 0x800100, 2, "object"),
]


@pytest.mark.parametrize(
    ("symbol", "name"),
    [
        ("loop", "loop()"),
        ("_Z4waitv", "wait()"),
        ("_ZL4spinii", "spin()"),
        ("_ZN14HardwareSerial5writeEh", "HardwareSerial::write()"),
        ("_ZNK6String6equalsERKS_", "String::equals()"),
        ("_ZN6StringC2EPKc", "String::String()"),
        ("_ZN6StringD1Ev", "String::~String()"),
        ("_ZN5Print5printEPKc.constprop.12", "Print::print()"),
        ("__vector_16", "ISR(TIMER0_OVF_vect)"),
        ("__vector_99", "__vector_99()"),
        ("_ZeqRK1AS1_", "_ZeqRK1AS1_"),
    ],
)
def test_names_are_those_of_the_source(symbol: str, name: str) -> None:
    assert source_name(symbol) == name


@pytest.mark.parametrize(
    ("address", "name"),
    [
        (0xFE, ""),
        (0x100, "loop()"),
        (0x11E, "loop()"),
        (0x120, ""),
        (0x20E, "wait()"),
        (0x700, "ISR(TIMER0_OVF_vect)"),
    ],
)
def test_functions_are_found_by_addresses(address: int, name: str) -> None:
    assert Functions(SYMBOLS).name_at(address) == name


@pytest.mark.parametrize("note", ProgramNote)
def test_each_kind_of_note_has_words(note: ProgramNote) -> None:
    topic, text = program_note(note + 256 * 0x200, 0x100, SYMBOLS)
    assert topic
    where = "wait()" if note is ProgramNote.ILLEGAL else "loop()"
    assert f", in {where}" in text
    assert ", in " not in program_note(note + 256 * 0x200, 0x100)[1]


def test_a_note_says_the_address_that_it_is_about() -> None:
    assert program_note(1 + 256 * 0x7FFE, 0)[1].startswith("at 0x7FFE stands an opcode")
    assert (
        "come down to 0x02F3, in loop(), into variables" in program_note(2 + 256 * 0x2F3, 0x102, SYMBOLS)[1]
    )
