"""Faults of a processor that happen once: a bit of a memory, and a sag of its supply."""

from hil.core.core_processor import CoreProcessor
from hil.vocab.faults import Fault
from hil.wire.byte_faults import Chance

SRAM = range(0x100, 0x900)
"""Addresses of the SRAM. Source: DS40002061, 8.3."""
BROWN_OUT = 1 << 2
"""BORF in MCUSR. Source: DS40002061, 11.9."""


def happen(fault: Fault, processor: CoreProcessor) -> None:
    """Carry out a fault that happens once, and is over."""
    if fault.kind == "chip_bit_flip":
        _flip(
            str(fault.parameters["memory"]), int(fault.number("address")), int(fault.number("bit")), processor
        )
    else:
        chance, kept = Chance(int(fault.number("seed"))), fault.number("kept_pct") / 100
        for address in SRAM:
            if chance.below(1 - kept):
                processor.poke(address, chance.bits() & 0xFF)
        if processor.is_running:
            processor.reset(0 if processor.has_boot else BROWN_OUT, processor.start_up_cycles)


def _flip(memory: str, address: int, bit: int, processor: CoreProcessor) -> None:
    """Invert a bit; nothing happens where the memory has no such address."""
    if memory == "flash":
        processor.load(address, bytes((processor.flash[address] ^ 1 << bit,)))
    elif memory == "eeprom" and address < len(processor.eeprom):
        processor.load_eeprom(address, bytes((processor.eeprom[address] ^ 1 << bit,)))
    elif memory == "sram" and address < SRAM.stop:
        processor.poke(address, processor.data(address, 1)[0] ^ 1 << bit)
