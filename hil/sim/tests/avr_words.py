"""Small programs for an ATmega328P, word by word. Encodings: instruction set manual DS40002198."""

import struct

UCSR0A, UCSR0B, UBRR0L, UDR0 = 0xC0, 0xC1, 0xC4, 0xC6
"""Addresses of the serial interface's registers. Source: DS40002061, 36."""
RXC0, UDRE0, TXC0 = 7, 5, 6
DDRB, PORTB, PINB, DDRD, PORTD, PIND = 0x04, 0x05, 0x03, 0x0A, 0x0B, 0x09
"""I/O addresses of ports B and D."""
SPCR, SPSR, SPDR = 0x2C, 0x2D, 0x2E
SPIF = 7
EECR, EEDR, EEARL = 0x1F, 0x20, 0x21
EEMPE, EEPE = 2, 1


def ldi(register: int, value: int) -> tuple[int]:
    return (0xE000 | value >> 4 << 8 | register - 16 << 4 | value & 15,)


def out(address: int, register: int) -> tuple[int]:
    return (0xB800 | address >> 4 << 9 | register << 4 | address & 15,)


def in_(register: int, address: int) -> tuple[int]:
    return (0xB000 | address >> 4 << 9 | register << 4 | address & 15,)


def sbi(address: int, bit: int) -> tuple[int]:
    return (0x9A00 | address << 3 | bit,)


def cbi(address: int, bit: int) -> tuple[int]:
    return (0x9800 | address << 3 | bit,)


def sbis(address: int, bit: int) -> tuple[int]:
    return (0x9B00 | address << 3 | bit,)


def sbrs(register: int, bit: int) -> tuple[int]:
    return (0xFE00 | register << 4 | bit,)


def lds(register: int, address: int) -> tuple[int, int]:
    return 0x9000 | register << 4, address


def sts(address: int, register: int) -> tuple[int, int]:
    return 0x9200 | register << 4, address


def rjmp(words: int) -> tuple[int]:
    """Jump so many words on from the next instruction."""
    return (0xC000 | words & 0xFFF,)


NOP = (0x0000,)


def program(*instructions: tuple[int, ...]) -> bytes:
    """Flash content of instructions."""
    words = [word for each in instructions for word in each]
    return struct.pack(f"<{len(words)}H", *words)


SERIAL_117647 = (
    *(ldi(16, 1 << 1), sts(UCSR0A, 16), ldi(16, 16), sts(UBRR0L, 16)),  # U2X0, 136 cycles a bit
    *(ldi(16, 0x18), sts(UCSR0B, 16)),  # RXEN0, TXEN0
)
"""Set-up of the serial interface, as Serial.begin(115200) sets it."""
TOGGLE = program(sbi(DDRB, 5), sbi(PINB, 5), rjmp(-2))
"""D13 changes each four cycles."""
ECHO = program(
    *SERIAL_117647, lds(17, UCSR0A), sbrs(17, RXC0), rjmp(-4), lds(18, UDR0), sts(UDR0, 18), rjmp(-9)
)
"""Each byte that comes is sent back."""
KEEP = program(
    ldi(16, 3), out(EEARL, 16), ldi(16, 0x5A), out(EEDR, 16), sbi(EECR, EEMPE), sbi(EECR, EEPE), rjmp(-1)
)
"""5Ah goes to address 3 of the EEPROM."""


def burst(driven_cycles: int | None) -> bytes:
    """Program that enables a line's driver by D2 when D3 is high, sends 55h, and lets the driver go: after so
    many cycles, or (None) when the last bit is out."""
    wait = [lds(17, UCSR0A), sbrs(17, TXC0), rjmp(-4)] if driven_cycles is None else [NOP] * driven_cycles
    return program(
        *SERIAL_117647,
        *(sbi(DDRD, 2), sbis(PIND, 3), rjmp(-2), sbi(PORTD, 2), ldi(18, 0x55), sts(UDR0, 18)),
        *wait,
        *(cbi(PORTD, 2), rjmp(-1)),
    )


PWM_64_OF_256 = program(
    *(sbi(DDRD, 6), ldi(16, 63), out(0x27, 16), ldi(16, 0x83), out(0x24, 16), ldi(16, 0x03), out(0x25, 16)),
    rjmp(-1),
)
"""Fast PWM of timer 0 at D6: 64 of 256 counts are high."""
ADCL, ADCH, RESULT = 0x78, 0x79, 0x100
CONVERT = program(
    *(ldi(16, 0x40), sts(0x7C, 16), ldi(16, 0xE7), sts(0x7A, 16), ldi(16, 0), sts(0x7B, 16)),
    *(lds(17, ADCL), lds(18, ADCH), sts(RESULT, 17), sts(RESULT + 1, 18), rjmp(-9)),
)
"""The converter measures A0 against AVCC, again and again; RESULT has two bytes."""
