"""Checks of notes on what a program does wrong, at a twin."""

import struct
from collections.abc import Callable

import pytest

from hil.sim.inputs import LoadProgram
from hil.sketch.chip_program import ChipProgram, packed
from hil.sketch.elf_file import Symbol
from hil.testing import Bench

FUNCTION = [Symbol("bad", 0, 0x20, "function"), Symbol("__heap_start", 0x800200, 0, "")]
PUSHES = [0x930F, 0xCFFE]  # push r16; rjmp .-4
ILLEGAL = [0x0000, 0x9000 + 0x0404, 0xCFFF]
SLEEP = [0xE005, 0xBF03, 0x94F8, 0x9588]  # ldi r16, 5; out SMCR, r16; cli; sleep


def words(*opcodes: int) -> bytes:
    return struct.pack(f"<{len(opcodes)}H", *opcodes)


@pytest.mark.parametrize(
    ("opcodes", "topic", "said"),
    [
        (PUSHES, "stack", "the stack has come down to 0x01FF, in bad(), into variables or the heap"),
        (ILLEGAL, "illegal opcode", "at 0x0002, in bad() stands an opcode that this chip does not have"),
        (SLEEP, "asleep", "the program sleeps, in bad(), and nothing but a reset can wake it"),
    ],
)
def test_what_goes_wrong_is_a_note(
    opcodes: list[int], topic: str, said: str, bench: Callable[..., Bench]
) -> None:
    made = bench({"bench": "b", "devices": {"u1": {"profile": "uno"}}})
    made.run(ms=1)
    program = packed(ChipProgram("bad.elf", words(*opcodes), symbols=tuple(FUNCTION)))
    made.runtime.apply_to(made.runtime.devices["u1"], LoadProgram(program.hex()))
    made.run(ms=200)
    assert made.device("u1").notes[topic].startswith(said)
    made.device("u1").reset()
    assert topic not in made.device("u1").notes
