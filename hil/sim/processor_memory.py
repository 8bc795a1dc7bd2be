"""Memories of a processor as they are written from outside."""

from hil.core.core_processor import CoreProcessor
from hil.sketch.chip import ERASED, FLASH
from hil.sketch.chip_program import ChipProgram

_BOOT_BYTES = (4096, 2048, 1024, 512)
"""Sizes of the boot section by BOOTSZ, bits 1 and 2 of the high fuse. Source: DS40002061, chapter 27."""


def load_program(processor: CoreProcessor, program: ChipProgram) -> None:
    """Write a program into the flash, and erase the rest of it up to the boot section."""
    boot_start = FLASH.size - _BOOT_BYTES[processor.fuses[1] >> 1 & 3]
    processor.load(0, program.flash.ljust(boot_start, bytes((ERASED,))))


def write_memory(processor: CoreProcessor, memory: str, at: int, data: bytes) -> None:
    """Do what ``WriteMemory`` says."""
    match memory:
        case "pc":
            processor.debug.jump(at)
        case "eeprom":
            processor.load_eeprom(at, data)
        case _:
            for address, byte in enumerate(data, at):
                processor.poke(address, byte)
