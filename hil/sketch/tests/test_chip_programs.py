"""Programs of files: what the chip has room for, what was built for another one, and the packed form."""

import subprocess
from pathlib import Path
from shutil import which

import pytest
from elf_files import elf_file

from hil.sketch.chip_program import (
    ChipProgram,
    flash_program,
    packed,
    read_program,
    unpacked,
    with_symbols,
)
from hil.sketch.intel_hex import write_hex
from hil.sketch.program_error import ProgramError

JUMPS = b"\x0c\x94\x34\x00" * 26
START = bytes.fromhex("1124 1fbe cfef d8e0 debf cdbf")
BLINK = JUMPS + START + b"\xff\xcf"


def read(*pieces: tuple[int, bytes]) -> ChipProgram:
    return read_program("x.hex", write_hex(pieces))


def refused(content: bytes, name: str = "x.hex") -> str:
    with pytest.raises(ProgramError) as error:
        read_program(name, content)
    return str(error.value)


def test_a_program_is_its_flash() -> None:
    program = read((0, BLINK), (0x200, b"\1\xff\xff"))
    assert program.flash == BLINK + b"\xff" * (0x200 - len(BLINK)) + b"\1"
    assert program.title == f"x.hex, 513 bytes, {program.digest[:12]}"
    assert program.digest == flash_program("uploaded", program.flash + b"\xff" * 100).digest
    assert (program.eeprom, program.fuses, program.lock, program.symbols) == (None, None, None, ())


def test_a_bootloader_has_the_size_from_its_first_byte_on() -> None:
    boot = read((0x7E00, BLINK))
    assert boot.start == 0x7E00
    assert boot.title == f"x.hex, {len(BLINK)} bytes, {boot.digest[:12]}"


def test_an_elf_file_and_a_hex_of_it_are_one_program() -> None:
    segments = [
        *((0, BLINK), (len(BLINK), b"data"), (0x810002, b"\7")),
        *((0x820000, b"\xff\xde\xfd"), (0x830000, b"\x0f"), (0x840000, b"\x0f\x95\x1e")),
    ]
    of_elf = read_program("x.elf", elf_file(segments, [("main", 8, 4, 2)], device="atmega328p"))
    of_hex = read(*segments)
    assert of_elf.flash == of_hex.flash == BLINK + b"data"
    assert of_elf.eeprom == of_hex.eeprom == b"\xff\xff\7"
    assert (of_elf.fuses, of_elf.lock) == (of_hex.fuses, of_hex.lock) == ((0xFF, 0xDE, 0xFD), 0x0F)
    assert of_elf.symbol("main") is not None
    assert (of_elf.symbol("other"), of_hex.symbol("main")) == (None, None)


def test_symbols_of_an_elf_file_are_taken_over_if_it_is_the_same_program() -> None:
    program, symbols = read((0, BLINK)), [("main", 8, 4, 2)]
    elf = elf_file([(0, BLINK)], symbols)
    assert [each.name for each in with_symbols(program, elf).symbols] == ["main"]
    for other in (elf_file([(0, BLINK + b"1")], symbols), b"", elf[:80]):
        assert with_symbols(program, other) == program


def test_the_whole_flash_can_be_used() -> None:
    assert len(read((0, bytes(32768))).flash) == 32768


@pytest.mark.parametrize(
    ("pieces", "said"),
    [
        ([], "x.hex: there is nothing in it for the flash (build the sketch again)"),
        ([(0, b"\xff\xff")], "x.hex: there is nothing in it for the flash"),
        ([(0x810000, b"\1")], "x.hex: there is nothing in it for the flash"),
        (
            [(0x7FF0, bytes(16)), (0x8000, bytes(20))],
            "x.hex:2:10: 0x8000 to 0x8013 lie behind its flash; a larger AVR has flash there, such as an"
            " ATmega2560; the flash of an ATmega328P ends at 0x7FFF (32,768 bytes)"
            " (build it for an Arduino Uno: -mmcu=atmega328p; or make it smaller)",
        ),
        ([(0x7FFF, bytes(2))], "x.hex:1:12: 0x8000 to 0x8000 lie behind its flash"),
        ([(0, BLINK), (0x800100, b"\1")], "0x800100 to 0x800100 lie in the RAM of an AVR"),
        ([(0x810000, bytes(1025))], "0x810400 to 0x810400 lie behind its EEPROM of 1,024 bytes"),
        ([(0x08000000, BLINK)], "lie in the flash of an STM32"),
        ([(0x40080000, BLINK)], "lie in the memory of an ESP32 or ESP8266"),
        ([(0x10000000, BLINK)], "lie in the flash of an RP2040"),
        ([(0x99999999, BLINK)], "0x99999999 to 0x99999A"),
        ([(0, BLINK), (0x840000, b"\x01\x98\x1e")], "another chip: its signature is 1E 98 01"),
        (
            [(0, JUMPS + START.replace(b"\xd8\xe0", b"\xd1\xe2"))],
            "x.hex: it is built for another chip: its stack begins at 0x21FF, and the last byte of an"
            " ATmega328P's RAM is 0x08FF (build it for an Arduino Uno: -mmcu=atmega328p)",
        ),
        ([(0, b"\x0e\xc0" * 15)], "it is built for another chip: its interrupt vectors are of one word"),
    ],
)
def test_what_the_chip_cannot_hold_or_run_is_refused(pieces: list[tuple[int, bytes]], said: str) -> None:
    assert said in refused(write_hex(pieces))


def test_places_come_before_what_overlaps() -> None:
    spilt = write_hex([(0x7FF0, bytes(20))], 20).splitlines()[0] + b"\n" + write_hex([(0x7FFE, b"\4\4")])
    assert "0x8000 to 0x8003 lie behind its flash" in refused(spilt)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"device": "atmega2560", "flags": 6}, "it is built for another chip: for an atmega2560 (build it"),
        ({"flags": 6}, "it is built for another chip: for avr6, and an ATmega328P is an avr5"),
        ({"device": "atmega32u4"}, "it is built for another chip: for an atmega32u4"),
    ],
)
def test_an_elf_file_says_its_chip(given: dict[str, object], said: str) -> None:
    assert said in refused(elf_file([(0, BLINK)], **given), "x.elf")


def test_segments_that_differ_where_they_overlap_are_refused() -> None:
    assert "x.elf: 0x0000 is " in refused(elf_file([(0, b"\1\2"), (0, b"\3")]), "x.elf")


def test_it_is_packed_and_unpacked() -> None:
    elf = elf_file(
        [(0, BLINK), (0x810000, b"\n\0"), (0x820000, b"\1\2\3"), (0x830000, b"\4")], [("m\u00e9", 1, 2, 1)]
    )
    for program in (read_program("b.elf", elf), flash_program("uploaded", b"\n\nx"), flash_program("", b"")):
        assert unpacked(packed(program)) == program


@pytest.mark.parametrize(
    "data", [b"", b"step/dir 1\nl 3", b"hil program 2\n{}\n", b"hil program 1\n[]\n", b"hil program 1\n{"]
)
def test_what_is_no_packed_program_is_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match="program"):
        unpacked(data)


SOURCE = """\
#include <avr/io.h>
#include <avr/eeprom.h>
uint8_t kept[3] EEMEM = {1, 2, 3};
int counts[2] = {1, 2};
int main(void) { for (;;) counts[PINB & 1]++; }
"""


def built(folder: Path, chip: str) -> Path:
    if which("avr-gcc") is None:
        pytest.skip("avr-gcc is not installed: apt install gcc-avr avr-libc")
    (folder / "x.c").write_text(SOURCE)
    subprocess.run(["avr-gcc", f"-mmcu={chip}", "-Os", "-o", "x.elf", "x.c"], cwd=folder, check=True)
    subprocess.run(["avr-objcopy", "-O", "ihex", "-R", ".eeprom", "x.elf", "x.hex"], cwd=folder, check=True)
    return folder


def test_what_a_compiler_makes(tmp_path: Path) -> None:
    folder = built(tmp_path, "atmega328p")
    of_elf, of_hex = (read_program(name, (folder / name).read_bytes()) for name in ("x.elf", "x.hex"))
    assert of_elf.digest == of_hex.digest
    assert of_elf.eeprom == b"\1\2\3"
    counts, main = of_elf.symbol("counts"), of_elf.symbol("main")
    assert counts is not None
    assert main is not None
    assert (counts.address, counts.size, counts.kind, main.kind) == (0x800100, 4, "object", "function")


@pytest.mark.parametrize("chip", ["atmega2560", "atmega32u4", "attiny85", "atmega8"])
def test_what_a_compiler_makes_for_another_chip_is_refused(tmp_path: Path, chip: str) -> None:
    folder = built(tmp_path, chip)
    for name in ("x.elf", "x.hex"):
        assert "it is built for another chip" in refused((folder / name).read_bytes(), name)
