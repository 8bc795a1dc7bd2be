"""Registers of an ATmega328P by name, with their addresses in data space.

Source: DS40002061, chapter 36 (register summary). General registers r0 to r31 are at 00h to 1Fh (7.4).
"""

from typing import NamedTuple


class ChipRegister(NamedTuple):
    """Register of the chip. ``bytes``: 2 for one of 16 bits, the low byte first. ``part``: of the chip, that
    it belongs to."""

    name: str
    address: int
    part: str
    bytes: int = 1


_PARTS = {
    "Ports": "PINB 23 DDRB 24 PORTB 25 PINC 26 DDRC 27 PORTC 28 PIND 29 DDRD 2A PORTD 2B",
    "External interrupts": "PCIFR 3B EIFR 3C EIMSK 3D PCICR 68 EICRA 69 PCMSK0 6B PCMSK1 6C PCMSK2 6D",
    "Timer 0": "TIFR0 35 TCCR0A 44 TCCR0B 45 TCNT0 46 OCR0A 47 OCR0B 48 TIMSK0 6E GTCCR 43",
    "Timer 1": "TIFR1 36 TIMSK1 6F TCCR1A 80 TCCR1B 81 TCCR1C 82 TCNT1 84* ICR1 86* OCR1A 88* OCR1B 8A*",
    "Timer 2": "TIFR2 37 TIMSK2 70 TCCR2A B0 TCCR2B B1 TCNT2 B2 OCR2A B3 OCR2B B4 ASSR B6",
    "Serial interface": "UCSR0A C0 UCSR0B C1 UCSR0C C2 UBRR0 C4* UDR0 C6",
    "SPI": "SPCR 4C SPSR 4D SPDR 4E",
    "TWI": "TWBR B8 TWSR B9 TWAR BA TWDR BB TWCR BC TWAMR BD",
    "Analogue": "ADC 78* ADCSRA 7A ADCSRB 7B ADMUX 7C DIDR0 7E DIDR1 7F ACSR 50",
    "EEPROM": "EECR 3F EEDR 40 EEAR 41*",
    "Clock and power": "SMCR 53 MCUSR 54 MCUCR 55 SPMCSR 57 WDTCSR 60 CLKPR 61 PRR 64 OSCCAL 66",
    "General purpose": "GPIOR0 3E GPIOR1 4A GPIOR2 4B",
}
"""Registers by the chip's parts: the name, and the address in hexadecimal digits; * has 16 bits."""


def _rows() -> list[ChipRegister]:
    rows = []
    for part, text in _PARTS.items():
        words = text.split()
        for name, place in zip(words[::2], words[1::2], strict=True):
            rows.append(ChipRegister(name, int(place.rstrip("*"), 16), part, 1 + place.endswith("*")))
    return rows


IO_REGISTERS = _rows()
"""All but the processor's own."""
STACK_POINTER = ChipRegister("SP", 0x5D, "Processor", 2)
STATUS = ChipRegister("SREG", 0x5F, "Processor")
GENERAL = [ChipRegister(f"r{number}", number, "Processor") for number in range(32)]
FLAGS = "CZNVSHTI"
"""Names of the status register's bits, the lowest first. Source: DS40002061, 7.3.1."""


def value_of(register: ChipRegister, data: bytes) -> int:
    """Value of a register in a copy of the data space."""
    return int.from_bytes(data[register.address : register.address + register.bytes], "little")
