"""A processor alone: programs in machine code that write their EEPROM."""

from hil.core._processor import Processor

EEDR, EEARL, EECR = 0x40, 0x41, 0x3F
MASTER, WRITE = 4, 2
"""EEMPE, EEPE."""


def store(address: int, value: int) -> list[int]:
    """Words of LDI r16 and STS."""
    return [0xE000 | value << 4 & 0xF00 | value & 15, 0x9300, address]


def test_a_byte_of_the_eeprom_is_written() -> None:
    """It is told where the write begins."""
    code = store(EEARL, 5) + store(EEDR, 0x5A)
    code += [0xE004, 0xE012, 0xBB0F, 0xBB1F]  # LDI r16, EEMPE; LDI r17, EEPE; OUT EECR of both
    processor = Processor()
    processor.load(b"".join(word.to_bytes(2, "little") for word in [*code, 0xCFFF]))
    processor.reset()
    assert processor.run(1000) == [(12, "stored", 5, 0)]
    assert processor.peek(EECR) & WRITE
    assert processor.eeprom[4:7] == b"\xff\x5a\xff"
    processor.run(60_000)
    assert not processor.peek(EECR) & (WRITE | MASTER)


def test_registers_are_looked_at_without_what_a_read_does() -> None:
    """A read of ADCL would lock the result, one of TCNT1L fill TEMP."""
    code = store(0x7C, 0x40) + store(0x81, 1) + store(0x7A, 0xC1)  # ADMUX; TCCR1B; ADCSRA: /2, begin
    processor = Processor()
    processor.load(b"".join(word.to_bytes(2, "little") for word in [*code, 0xCFFF]))
    processor.supply(5.0, 5.0)
    processor.volts(0, 2.5)
    processor.reset()
    processor.run(1000)
    assert (processor.peek(0x78), processor.peek(0x79)) == (0x00, 0x02)  # ADCL, ADCH: 512
    before = processor.peek(0x84) | processor.peek(0x85) << 8  # TCNT1
    assert processor.peek(0x84) | processor.peek(0x85) << 8 == before
    processor.run(1300)
    assert processor.peek(0x84) | processor.peek(0x85) << 8 == before + 300
    assert (processor.peek(0x86), processor.peek(0x87)) == (0, 0)  # ICR1
    processor.volts(0, 5.0)
    processor.poke(0x7A, 0x00)
    assert processor.peek(0x78) == 0x00
