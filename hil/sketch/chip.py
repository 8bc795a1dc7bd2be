"""Memories of an ATmega328P, and the addresses that avr-gcc gives them.

Source: DS40002061, chapters 8 (AVR memories), 27 (boot loader support) and 28 (memory programming);
the offsets of what is not flash: GNU binutils, ld's scripts for AVR.
"""

from typing import NamedTuple


class Space(NamedTuple):
    """One of the chip's memories, at the addresses that it has in a file."""

    start: int
    size: int

    @property
    def end(self) -> int:
        return self.start + self.size


CHIP = "ATmega328P"
FLASH = Space(0, 32768)
DATA_AT = 0x800000
"""Address in a file at which the data space begins: registers, I/O, SRAM."""
RAM = Space(DATA_AT + 0x100, 2048)
EEPROM = Space(0x810000, 1024)
FUSES, LOCK, SIGNED = Space(0x820000, 3), Space(0x830000, 1), Space(0x840000, 3)
SPACES = FLASH, EEPROM, FUSES, LOCK, SIGNED
"""Memories that a file may have bytes for, by their addresses."""


def boot_section(start: int) -> Space:
    """Find the smallest boot section that has a bootloader with this first byte."""
    return next(section for section in BOOT_SECTIONS if section.start <= start)


PAGE_BYTES = 128
"""Size of a page of the flash, which is erased and written as a whole."""
BOOT_SECTIONS = tuple(Space(FLASH.size - size, size) for size in (512, 1024, 2048, 4096))
"""Boot sections that the fuses can choose, from BOOTSZ 3 down to 0. Source: DS40002061, chapter 27."""
BOOT_START = BOOT_SECTIONS[0].start
"""First byte of the boot section with an Arduino Uno's fuses."""
NRWW_START = 0x7000
"""First byte of the section that can be read only when none of its pages is being written."""
SIGNATURE = bytes((0x1E, 0x95, 0x0F))
ERASED = 0xFF
"""Content of a byte of flash or EEPROM that nothing has written since it was erased."""
