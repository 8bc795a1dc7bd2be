"""ELF files of an AVR: segments, symbols, the device, and what is refused."""

from contextlib import suppress
from random import Random

import pytest
from elf_files import elf_file

from hil.sketch.elf_file import Symbol, read_elf
from hil.sketch.program_error import ProgramError

SEGMENTS = [(0, b"\x0c\x94\x34\x00"), (4, b"\x01\x02")]
SYMBOLS = [("main", 0, 4, 2), ("count", 0x800100, 2, 1), ("__heap_start", 0x800102, 0, 0)]


def refused(content: bytes) -> str:
    with pytest.raises(ProgramError) as error:
        read_elf("x.elf", content)
    return str(error.value)


def test_segments_symbols_and_the_device() -> None:
    elf = read_elf("x.elf", elf_file(SEGMENTS, SYMBOLS, device="atmega328p"))
    assert [(piece.at, piece.data) for piece in elf.pieces] == SEGMENTS
    assert elf.symbols == [
        Symbol("main", 0, 4, "function"),
        Symbol("count", 0x800100, 2, "object"),
        Symbol("__heap_start", 0x800102, 0, ""),
    ]
    assert (elf.architecture, elf.device) == (5, "atmega328p")


def test_a_stripped_file_has_no_symbols() -> None:
    elf = read_elf("x.elf", elf_file(SEGMENTS))
    assert (elf.symbols, elf.device) == ([], "")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b":00000001FF\n", "x.elf: it is no ELF file (give the .elf that avr-gcc links)"),
        (b"\x7fELF", "x.elf: the header is at byte 0 to 51, and the file has 4 (build or copy"),
        (elf_file(SEGMENTS, word_class=2), "x.elf: it is an ELF file of 64 bits, little endian; an AVR's"),
        (elf_file(SEGMENTS, machine=40), "x.elf: it is built for Arm, not for an AVR (build it with"),
        (elf_file(SEGMENTS, machine=7), "x.elf: it is built for machine 7, not for an AVR"),
        (elf_file(SEGMENTS, kind=1), "x.elf: it is no executable: it is not linked (give the .elf"),
    ],
)
def test_what_is_no_program_is_refused(content: bytes, said: str) -> None:
    assert refused(content).startswith(said)


def test_a_cut_file_is_refused_wherever_it_is_cut() -> None:
    content = elf_file(SEGMENTS, SYMBOLS, device="atmega328p")
    for size in range(4, len(content)):
        assert f"the file has {size}" in refused(content[:size])


def test_segments_have_no_more_bytes_than_the_file() -> None:
    content = elf_file([(0, b"ab" * 200)] * 3)
    fewer = bytearray(content)
    for number in range(3):
        at = 52 + 32 * number
        fewer[at + 4 : at + 8] = (0).to_bytes(4, "little")
        fewer[at + 16 : at + 20] = len(content).to_bytes(4, "little")
    assert "its segments have more bytes than the file" in refused(bytes(fewer))


def test_damage_raises_nothing_else() -> None:
    random, whole = Random(1), elf_file(SEGMENTS, SYMBOLS, device="atmega328p")
    for _ in range(3000):
        content = bytearray(whole)
        for _ in range(random.randrange(1, 6)):
            content[random.randrange(len(content))] = random.randrange(256)
        with suppress(ProgramError):
            read_elf("x.elf", bytes(content))
