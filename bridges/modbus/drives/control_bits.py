"""Writes of a drive: words of a value, and words that switch its bits without touching those beside them."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.drive_map import DriveMap, RegisterPlace


@dataclass(frozen=True)
class RegisterWrite:
    """Write of words from an address on, or of bits of a table of bits (0 and 1). ``keeps``: bits of the one
    register that stay as the drive has them."""

    table: Table
    address: int
    words: tuple[int, ...]
    keeps: int = 0


def value_write(of: DriveMap, place: RegisterPlace, value: float) -> RegisterWrite:
    """Write of a value. Raises ValueError: its registers cannot hold it."""
    if not place.holds(value):
        raise ValueError(f"the registers of the drive cannot hold {value:g}")
    words = place.words(value, is_low_first=of.is_low_first)
    return RegisterWrite(place.table, place.address, words, settings_beside(of, place))


def settings_beside(of: DriveMap, place: RegisterPlace) -> int:
    """Bits of a place's register that are settings of others; 0 of a place that has all of it. Commands that
    clear themselves are none: with them again they would be given again."""
    if (own := place.bits) is None:
        return 0
    parts, found = of.parts, 0
    others = [*of.values.values(), *of.parameters.values(), *(place for _, place in parts.also)]
    others += [each for each in of.control.values() if not each.on_write]
    others += [each for each, cell in parts.cells.values() if cell.is_written and cell.is_read]
    others += [each for each, command in parts.commands.values() if command.is_kept or command.sets_mode]
    for other in others:
        if (other.table, other.address) == (place.table, place.address):
            found |= other.bits or 0
    return found & ~own


def bits_write(
    of: DriveMap, wanted: Mapping[str, bool], known: Mapping[int, int]
) -> tuple[RegisterWrite, ...]:
    """Writes that switch control bits, by name; those that the map has not are left out. Bits of one register
    are switched by one write, with its other bits as they are ``known``, holding registers by address; 0 of
    one that nobody knows, or of one that is a command with each write: that clears itself."""
    commands: dict[int, int] = defaultdict(int)
    for each in of.control.values():
        if each.on_write and each.bit is not None:
            commands[each.address] |= 1 << each.bit
    coils: list[RegisterWrite] = []
    words: dict[int, int] = {}
    for name, level in wanted.items():
        place = of.control.get(name)
        if place is None or (place.on_write and not level):
            continue
        if place.bit is None:
            coils.append(RegisterWrite(place.table, place.address, (int(level),)))
            continue
        word = words.get(place.address, known.get(place.address, 0) & ~commands[place.address])
        words[place.address] = word | 1 << place.bit if level else word & ~(1 << place.bit)
    return (
        *(RegisterWrite(Table.HOLDING_REGISTERS, address, (word,)) for address, word in words.items()),
        *coils,
    )
