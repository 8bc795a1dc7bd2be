"""A program for the processor: what a file has for its flash, its EEPROM and its fuses, and its symbols.

A board's memory keeps it as ``packed``: a line with the version, a line of JSON, the bytes.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from typing import Any

from hil.sketch.chip import (
    BOOT_SECTIONS,
    BOOT_START,
    CHIP,
    EEPROM,
    ERASED,
    FLASH,
    FUSES,
    LOCK,
    PAGE_BYTES,
    SIGNATURE,
    SIGNED,
    SPACES,
    Space,
)
from hil.sketch.elf_file import MAGIC, ElfFile, Symbol, read_elf
from hil.sketch.intel_hex import FilePiece, check_overlaps, read_hex
from hil.sketch.other_chips import ARCHITECTURE, DEVICES, other_chip, place_of
from hil.sketch.program_error import ProgramError, program_error
from hil.vocab.late_dataclass import dataclass

SECTION, BOOT_SECTION = "program", "bootloader"
"""Sections of a board's memory that its program is kept in, and a bootloader of the user's own."""
MOST_FILE_BYTES = 8_000_000
"""Maximum length of a file: an ELF file with all that a debugger wants has some hundred kilobytes."""
UPLOADED = "what was uploaded"
"""Name of a program that came over the serial port."""
_VERSION = b"hil program 1"
_FOR_UNO = "build it for an Arduino Uno: -mmcu=atmega328p"
_SHORT_DIGEST = 12
_ERASED = bytes((ERASED,))


@dataclass(frozen=True)
class ChipProgram:
    """Program as it stands in the chip. ``flash``: its bytes from 0 on, to the last that is not FFh;
    ``eeprom``: likewise, None if the file has none; ``fuses``: low, high, extended, as the file has them,
    and ``lock``; None if it has none. ``symbols``: by their addresses; of a hex file none."""

    name: str
    flash: bytes
    eeprom: bytes | None = None
    fuses: tuple[int, int, int] | None = None
    lock: int | None = None
    symbols: tuple[Symbol, ...] = ()

    @property
    def digest(self) -> str:
        """SHA-256 of the flash, in hexadecimal digits: the same for a file and its upload."""
        return sha256(self.flash).hexdigest()

    @property
    def start(self) -> int:
        """Address of the first word that is not FFFFh."""
        return (len(self.flash) - len(self.flash.lstrip(_ERASED))) & ~1

    @property
    def title(self) -> str:
        """Name, size from the first byte on, and beginning of the digest, in words."""
        return f"{self.name}, {len(self.flash) - self.start} bytes, {self.digest[:_SHORT_DIGEST]}"

    def symbol(self, name: str) -> Symbol | None:
        """Look a symbol up by its name."""
        return next((symbol for symbol in self.symbols if symbol.name == name), None)


def kept_symbols(memory: Mapping[str, bytes]) -> tuple[Symbol, ...]:
    """Symbols of the program that a board's memory keeps; none if it keeps none, or knows no symbols."""
    try:
        return unpacked(memory[SECTION]).symbols
    except (KeyError, ValueError):
        return ()


def is_program(section: bytes | None) -> bool:
    """True if a section of a board's memory has a program that is more than an erased flash."""
    try:
        return bool(section) and bool(unpacked(section or b"").flash)
    except ValueError:
        return False


def flash_program(name: str, flash: bytes) -> ChipProgram:
    """Make the program that a flash holds."""
    return ChipProgram(name, flash.rstrip(_ERASED))


def before_boot(program: ChipProgram, boot_start: int = BOOT_START) -> ChipProgram:
    """Cut off the bootloader that some tools put behind a program.

    Raises:
        ProgramError: the program itself reaches into the boot section.
    """
    left = program.flash[:boot_start]
    if len(program.flash) > boot_start and left[-PAGE_BYTES:].strip(_ERASED):
        size = f"{len(program.flash):,} bytes"
        message = f"its {size} reach into the boot section, which begins at 0x{boot_start:04X}"
        raise program_error(program.name, message, f"make it smaller: it has room for {boot_start:,} bytes")
    return replace(program, flash=left.rstrip(_ERASED))


def as_bootloader(program: ChipProgram) -> ChipProgram:
    """Check that a program is a bootloader. Raises ProgramError: it does not begin in a boot section."""
    if program.start < BOOT_SECTIONS[-1].start:
        message = (
            f"it is no bootloader: it begins at 0x{program.start:04X}, and the largest boot section at"
            f" 0x{BOOT_SECTIONS[-1].start:04X}"
        )
        remedy = f"link it for the boot section, as with -Wl,--section-start=.text=0x{BOOT_START:04X}"
        raise program_error(program.name, message, remedy)
    return program


def read_program(name: str, content: bytes) -> ChipProgram:
    """Read a program of an Intel HEX or an ELF file. ``name``: of the file, without folders.

    Raises:
        ProgramError: it is damaged, no such file, empty, too large, or built for another chip.
    """
    elf = read_elf(name, content) if content[: len(MAGIC)] == MAGIC else None
    if elf:
        _check_device(name, elf)
    pieces = sorted(elf.pieces) if elf else read_hex(name, content)
    _check_places(name, pieces)
    check_overlaps(name, pieces)
    made = flash_program(name, _image(pieces, FLASH))
    if not made.flash:
        raise program_error(name, "there is nothing in it for the flash", "build the sketch again")
    eeprom, fuses, lock, signature = (_image(pieces, space) for space in (EEPROM, FUSES, LOCK, SIGNED))
    # The compiler's library has the bytes in a file the other way round.
    if signature not in (b"", SIGNATURE, SIGNATURE[::-1]):
        raise _for_another(name, f"its signature is {signature[::-1].hex(' ').upper()}")
    if reason := other_chip(made.flash):
        raise _for_another(name, reason)
    return replace(
        made,
        eeprom=eeprom or None,
        fuses=(fuses[0], fuses[1], fuses[2]) if len(fuses) == FUSES.size else None,
        lock=lock[0] if lock else None,
        symbols=tuple(elf.symbols) if elf else (),
    )


def with_symbols(program: ChipProgram, elf: bytes) -> ChipProgram:
    """Take over the symbols of an ELF file, as of the one beside a hex file. The program stays as it is if
    that file is none, or is of another build."""
    try:
        other = read_program(program.name, elf)
    except ProgramError:
        return program
    return replace(program, symbols=other.symbols) if other.flash == program.flash else program


def _for_another(name: str, reason: str) -> ProgramError:
    return program_error(name, f"it is built for another chip: {reason}", _FOR_UNO)


def _check_device(name: str, elf: ElfFile) -> None:
    if elf.device and elf.device not in DEVICES:
        raise _for_another(name, f"for an {elf.device}")
    if elf.architecture != ARCHITECTURE:
        raise _for_another(name, f"for avr{elf.architecture}, and an {CHIP} is an avr{ARCHITECTURE}")


def _image(pieces: Iterable[FilePiece], space: Space) -> bytes:
    """Bytes of a memory, from its first to the last that a piece has; what nothing has is erased."""
    image, used = bytearray((ERASED,)) * space.size, 0
    for piece in pieces:
        first, end = max(piece.at, space.start), min(piece.end, space.end)
        if first < end:
            image[first - space.start : end - space.start] = piece.data[first - piece.at : end - piece.at]
            used = max(used, end - space.start)
    return bytes(image[:used])


def _check_places(name: str, pieces: Sequence[FilePiece]) -> None:
    """Check that the chip has a memory for each byte of pieces in the order of their addresses."""
    outside = [(at, piece) for piece in pieces if (at := _first_outside(piece)) is not None]
    if not outside:
        return
    first, piece = outside[0]
    last = first
    for at, each in outside:
        last = max(last, each.end - 1) if at <= last + 1 else last
    message = (
        f"0x{first:04X} to 0x{last:04X} lie {place_of(first)}; the flash of an {CHIP} ends at"
        f" 0x{FLASH.end - 1:04X} ({FLASH.size:,} bytes)"
    )
    remedy = f"{_FOR_UNO}; or make it smaller" if first == FLASH.end else _FOR_UNO
    raise program_error(name, message, remedy, *piece.place(first))


def _first_outside(piece: FilePiece) -> int | None:
    """First address of a piece that the chip has no memory for."""
    at = piece.at
    for space in SPACES:
        if space.start <= at < space.end:
            at = space.end
    return at if at < piece.end else None


def packed(program: ChipProgram) -> bytes:
    """Pack a program for a board's memory."""
    head: dict[str, Any] = {"name": program.name, "flash": len(program.flash)}
    if program.eeprom is not None:
        head["eeprom"] = len(program.eeprom)
    if program.fuses is not None:
        head["fuses"] = program.fuses
    if program.lock is not None:
        head["lock"] = program.lock
    if program.symbols:
        head["symbols"] = program.symbols
    text = json.dumps(head, separators=(",", ":")).encode()
    return b"\n".join((_VERSION, text, program.flash + (program.eeprom or b"")))


def unpacked(data: bytes) -> ChipProgram:
    """Read what ``packed`` has made.

    Raises:
        ValueError: it is something else, or of a later version.
    """
    version, _, rest = data.partition(b"\n")
    text, _, content = rest.partition(b"\n")
    if version != _VERSION:
        raise ValueError("the memory has a program in a form that this hil does not know")
    try:
        head = json.loads(text)
        size = int(head["flash"])
        return ChipProgram(
            name=str(head["name"]),
            flash=content[:size],
            eeprom=content[size:] if "eeprom" in head else None,
            fuses=tuple(head["fuses"]) if "fuses" in head else None,
            lock=head.get("lock"),
            symbols=tuple(Symbol(*row) for row in head.get("symbols", ())),
        )
    except (TypeError, KeyError, ValueError) as error:
        raise ValueError(f"the memory's program is damaged: {error}") from error
