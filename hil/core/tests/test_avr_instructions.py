"""Single instructions of the ATmega328P: 440 of them, with all that they change, against simavr.

``avr_vectors/instructions.jsonl.gz`` was made with simavr 1.6 (Debian): words, registers, SP and SREG before;
PC, clocks, SREG, SP and each byte of data space that changed after.
"""

import gzip
import json
from pathlib import Path
from typing import Any

import pytest

from hil.core._processor import Processor

VECTORS = Path(__file__).parent / "avr_vectors" / "instructions.jsonl.gz"
FLASH_WORDS, RAM, RAM_END = 0x4000, 0x100, 0x900
AT = 0x1000
"""Word that the instruction is at."""
SPL, SPH, SREG = 0x5D, 0x5E, 0x5F
STATUS = {SPL, SPH, SREG}


def vectors() -> list[dict[str, Any]]:
    return [json.loads(line) for line in gzip.decompress(VECTORS.read_bytes()).splitlines()]


def flash(words: list[int]) -> bytes:
    """Flash that is the same but for an instruction and the word after it."""
    whole = [(word * 0x1235 + 0x5678) & 0xFFFF for word in range(FLASH_WORDS)]
    whole[AT : AT + len(words)] = words
    return b"".join(word.to_bytes(2, "little") for word in whole)


def prepared(vector: dict[str, Any]) -> Processor:
    chip = Processor()
    chip.load(flash(vector["words"]))
    chip.reset()
    for address in range(RAM, RAM_END):
        chip.poke(address, (7 * address + (address >> 8) + 3) & 0xFF)
    for number, value in enumerate(bytes.fromhex(vector["r"])):
        chip.poke(number, value)
    for address, value in zip((0x3E, 0x4A, 0x4B), vector["gpior"], strict=True):
        chip.poke(address, value)
    chip.poke(SPL, vector["sp"] & 0xFF)
    chip.poke(SPH, vector["sp"] >> 8)
    chip.poke(SREG, vector["sreg"])
    if vector["name"] in ("RET", "RETI"):
        high = vector["sp"] + 1
        chip.poke(high, chip.peek(high) & 0x3F)
    chip.set_pc(2 * AT)
    return chip


def data_of(chip: Processor) -> list[int]:
    return [chip.peek(address) for address in range(RAM_END)]


@pytest.mark.parametrize("name", sorted({each["name"] for each in vectors()}))
def test_an_instruction_does_what_it_does(name: str) -> None:
    for vector in (each for each in vectors() if each["name"] == name):
        chip, after = prepared(vector), vector["after"]
        before = data_of(chip)
        clocks = after["cycles"]
        chip.run(clocks - 1)
        assert chip.registers()["pc"] == 2 * AT, (vector, "it ended too early")
        chip.run(clocks)
        now = data_of(chip)
        changed = {
            str(address): value
            for address, value in enumerate(now)
            if value != before[address] and address not in STATUS
        }
        registers = chip.registers()
        assert registers["pc"] == 2 * after["pc"], vector
        assert registers["sp"] == after["sp"], vector
        assert registers["sreg"] == after["sreg"], vector
        expected = {key: value for key, value in after["data"].items() if int(key) not in STATUS}
        assert changed == expected, vector


def test_there_are_vectors() -> None:
    assert len(vectors()) == 440
