"""Signs of a program that is built for another chip than the ATmega328P."""

import re
import struct

from hil.sketch.chip import CHIP, EEPROM, FLASH, FUSES, RAM

ARCHITECTURE = 5
"""Number of the ATmega328P's kind of core, avr5, in an ELF file."""
DEVICES = ("atmega328p", "atmega328")
"""Names that avr-gcc has for it, and for the same without picoPower."""
_IN_FILE = 0x800000
"""Address in a file of the first byte of data memory."""
_LAST_RAM = RAM.end - 1 - _IN_FILE
_PLACES = (
    (FLASH.end, 0x40000, "behind its flash; a larger AVR has flash there, such as an ATmega2560"),
    (_IN_FILE, EEPROM.start, "in the RAM of an AVR, which no program is loaded into"),
    (EEPROM.end, FUSES.start, "behind its EEPROM of 1,024 bytes"),
    (0x08000000, 0x08200000, "in the flash of an STM32"),
    (0x10000000, 0x12000000, "in the flash of an RP2040"),
    (0x20000000, 0x20200000, "in the RAM of an Arm Cortex-M"),
    (0x3FF00000, 0x40500000, "in the memory of an ESP32 or ESP8266"),
)
"""Address ranges of microcontrollers that people have, and what is there. Sources: memory maps in their data
sheets."""

_STACK_SET_UP = re.compile(
    rb"\x11\x24\x1f\xbe([\xc0-\xcf][\xe0-\xef])([\xd0-\xdf][\xe0-\xef])\xde\xbf\xcd\xbf", re.S
)
"""Begin of avr-libc's start-up: EOR r1,r1; OUT SREG,r1; LDI r28; LDI r29; OUT SPH,r29; OUT SPL,r28."""
_RJMP, _RJMP_MASK = 0xC000, 0xF000
_LEAST_SHORT_VECTORS = 10
"""Number of vectors of the smallest AVRs, of one word each: an ATtiny13's."""


def place_of(address: int) -> str:
    """Describe what an address is that is no place for a program, as in "in the flash of an STM32"."""
    return next((about for first, end, about in _PLACES if first <= address < end), "behind its flash")


def other_chip(flash: bytes) -> str:
    """Say by what one sees that a program from address 0 is built for another chip; empty: by nothing."""
    words = [word for (word,) in struct.iter_unpack("<H", flash[: 2 * _LEAST_SHORT_VECTORS])]
    if len(words) >= _LEAST_SHORT_VECTORS and all(
        word & _RJMP_MASK == _RJMP for word in words[:_LEAST_SHORT_VECTORS]
    ):
        return "its interrupt vectors are of one word, as in AVRs with at most 8 kB of flash"
    if (found := _STACK_SET_UP.search(flash[:0x400])) and (top := _loaded(*found.groups())) > _LAST_RAM:
        return f"its stack begins at 0x{top:04X}, and the last byte of an {CHIP}'s RAM is 0x{_LAST_RAM:04X}"
    return ""


def _loaded(low: bytes, high: bytes) -> int:
    """Value that two LDI load."""
    return _constant(high) << 8 | _constant(low)


def _constant(instruction: bytes) -> int:
    return (instruction[1] & 0xF) << 4 | instruction[0] & 0xF
