"""Flash and EEPROM of the processor, and the sections of the board's memory that keep them."""

from hil.firmware.bootloader import Steps
from hil.sketch.chip import BOOT_SECTIONS, DATA_AT, EEPROM, ERASED, FLASH, RAM, boot_section
from hil.sketch.chip_program import (
    BOOT_SECTION,
    SECTION,
    UPLOADED,
    ChipProgram,
    flash_program,
    packed,
    unpacked,
)
from hil.vocab.firmware import Board, Commit, Processor

EEPROM_SECTION = "eeprom"
LOCK = 0x0F
"""Lock bits: no program writes into the boot section. Source: boards.txt of the Arduino AVR core."""
_NO_BOOT = 0b1
"""Bit of the high fuse (BOOTRST) that lets a reset begin at address 0."""
_SIZE_BITS = 0b110
"""Bits of the high fuse that have the boot section's size."""
_EMPTY = bytes((ERASED,)) * EEPROM.size
NOT_KEPT = "the memory could not be written: the flash is lost without power"


class ChipMemory:
    """Flash and EEPROM of one power-up. The chip's are the right ones: the memory's are put into it when it
    has none, and follow it. ``has_bootloader``: hil answers for a bootloader, unless the flash has one."""

    def __init__(self, board: Board, processor: Processor, *, has_bootloader: bool = True) -> None:
        self._board, self._processor, self._is_answered = board, processor, has_bootloader
        self._bootloader = self._stored(BOOT_SECTION)
        self._boot_start = BOOT_SECTIONS[0].start if has_bootloader else FLASH.size
        self.program = self._stored(SECTION)
        """Program that the chip has beside its bootloader; None: none."""
        self._is_durable = True
        """True if the memory keeps that program."""

    @property
    def has_bootloader(self) -> bool:
        """True if the chip has a bootloader of its own in its flash."""
        return self._bootloader is not None

    @property
    def title(self) -> str:
        """Description of what is in the flash."""
        titles = [each.title for each in (self.program, self._bootloader) if each]
        return " behind the bootloader ".join(titles)

    @property
    def heap_start(self) -> int:
        """Address behind the program's variables; the first of SRAM if it has no symbols."""
        symbol = self.program.symbol("__heap_start") if self.program else None
        return symbol.address - DATA_AT if symbol else RAM.start - DATA_AT

    def _stored(self, section: str) -> ChipProgram | None:
        data = self._board.nvm.get(section)
        if not data:
            return None
        try:
            program = unpacked(data)
        except ValueError as error:
            self._board.note(section, str(error))
            return None
        return program if program.flash else None

    def put_in(self) -> None:
        """Set the fuses, and fill a chip that is empty."""
        processor, fuses = self._processor, self._processor.fuses[:3]
        if self._bootloader:
            start = self._bootloader.start
            section = boot_section(start)
            self._boot_start = section.start
            size = len(BOOT_SECTIONS) - 1 - BOOT_SECTIONS.index(section)
            fuses = (fuses[0], fuses[1] & ~(_SIZE_BITS | _NO_BOOT) | size << 1, fuses[2])
            processor.load(start, self._bootloader.flash[start:])
        elif not self._is_answered:
            fuses = (fuses[0], fuses[1] | _NO_BOOT, fuses[2])
        has_boot = self._is_answered and not self._bootloader
        processor.set_fuses(*fuses, LOCK, has_boot=has_boot)
        if self.program and not self._flash():
            processor.load(0, self.program.flash[: self._boot_start])
        if processor.eeprom == _EMPTY:
            processor.load_eeprom(0, self._stored_eeprom() or self._first_eeprom())

    def _flash(self) -> bytes:
        """Content of the flash before the boot section, without what is erased behind it."""
        return self._processor.flash[: self._boot_start].rstrip(bytes((ERASED,)))

    def _stored_eeprom(self) -> bytes:
        """Content of the EEPROM as it is kept; empty: the section is that of another sketch."""
        data = self._board.nvm.get(EEPROM_SECTION, b"")
        return data if len(data) == EEPROM.size else b""

    def _first_eeprom(self) -> bytes:
        return (self.program.eeprom or b"") if self.program else b""

    @property
    def is_kept(self) -> bool:
        """True if the memory has all that is in the chip."""
        return self._flash() == self._known and self._processor.eeprom == (self._stored_eeprom() or _EMPTY)

    @property
    def _known(self) -> bytes:
        return self.program.flash[: self._boot_start] if self.program else b""

    def keep(self) -> Steps:
        """Make the memory follow the chip."""
        flash, eeprom = self._flash(), self._processor.eeprom
        if flash != self._known or not self._is_durable:
            program = flash_program(UPLOADED, flash)
            self._is_durable = yield Commit(SECTION, packed(program))
            self.program = program if flash else None
        durable = self._is_durable
        if eeprom != (self._stored_eeprom() or _EMPTY):
            durable = (yield Commit(EEPROM_SECTION, eeprom)) and durable
        self._board.note("memory", None if durable else NOT_KEPT)
