"""Checks of the table of registers."""

import re
from pathlib import Path

import pytest

from hil.sketch.register_names import GENERAL, IO_REGISTERS, STACK_POINTER, STATUS, value_of

AVR_LIBC = Path("/usr/lib/avr/include/avr/iom328p.h")
OTHER_NAMES = {"ADCW", "ADCL", "ADCH"}
"""Names that avr-libc has beside those of the data sheet, and halves of registers of 16 bits."""


def test_no_two_registers_share_a_byte() -> None:
    rows = [*IO_REGISTERS, *GENERAL, STACK_POINTER, STATUS]
    places = [row.address + i for row in rows for i in range(row.bytes)]
    assert len(places) == len(set(places))
    assert max(places) < 0x100


def test_values_have_the_low_byte_first() -> None:
    data = bytearray(0x100)
    data[0x84:0x86] = b"\x34\x12"
    timer = next(row for row in IO_REGISTERS if row.name == "TCNT1")
    assert value_of(timer, bytes(data)) == 0x1234


@pytest.mark.skipif(not AVR_LIBC.exists(), reason="avr-libc is not installed")
def test_the_compiler_has_the_same_addresses() -> None:
    text = AVR_LIBC.read_text()
    found = re.findall(r"^#define (\w+)\s+_SFR_(IO|MEM)(8|16)\((0x\w+)\)", text, re.M)
    theirs = {name: (int(at, 16) + 0x20 * (kind == "IO"), int(bits) // 8) for name, kind, bits, at in found}
    wide = {name for name, (_, count) in theirs.items() if count == 2}
    halves = {f"{name}{half}" for name in wide for half in "LH"} | OTHER_NAMES
    assert {row.name: (row.address, row.bytes) for row in IO_REGISTERS} == {
        name: place for name, place in theirs.items() if name not in halves
    }
