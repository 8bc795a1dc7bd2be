"""Overlaps in a Modbus drive's map: registers and bits that two entries would have."""

from collections.abc import Iterator, Mapping

from bridges.modbus.protocol.pdu import ADDRESSES, Table
from bridges.modbus.registers.drive_map import RegisterPlace
from hil.config.document import Finding, KeyPath

_WORDS = {
    Table.INPUT_REGISTERS: "input",
    Table.HOLDING_REGISTERS: "holding",
    Table.DISCRETE_INPUTS: "discrete",
    Table.COILS: "coil",
}


def overlap_findings(
    places: Mapping[KeyPath, RegisterPlace], lines: Mapping[KeyPath, int]
) -> Iterator[Finding]:
    """Findings of entries that share a register or a bit with one before them. ``places``: in file order;
    ``lines``: where they are in the file."""
    taken: dict[tuple[Table, int], list[tuple[KeyPath, RegisterPlace]]] = {}
    for path, place in places.items():
        registers = range(place.address, place.address + place.width)
        clashes = (
            (register, owner)
            for register in registers
            for owner in taken.get((place.table, register), ())
            if not _share(place, owner[1])
        )
        if clash := next(clashes, None):
            register, (other_path, other) = clash
            yield Finding(*_told(path, place, register, other_path, other, lines[other_path]))
            continue  # what it would have is not taken from a third
        for register in registers:
            taken.setdefault((place.table, register), []).append((path, place))


def _share(one: RegisterPlace, other: RegisterPlace) -> bool:
    """True if two entries can be in one register: as different bits of it."""
    own, others = one.bits, other.bits
    return own is not None and others is not None and not own & others


def _told(
    path: KeyPath, place: RegisterPlace, register: int, other_path: KeyPath, other: RegisterPlace, line: int
) -> tuple[KeyPath, str, str]:
    word = _WORDS[place.table]
    whose = ".".join(map(str, other_path)) + (f" (line {line})" if line else "")
    is_in_block = place.address >= ADDRESSES
    if is_in_block or place.mask is not None or other.mask is not None:
        where = f"register {register & 0xFFFF} of the block" if is_in_block else f"{word} {register}"
        key = "at" if is_in_block else word
        bits = [] if place.bits is None else [f"bits {place.bits:04X}h"]
        message = f"{' and '.join([where, *bits])}: {whose} is there"
        return (*path, key), message, "write a register that is free, or bits that are"
    at, free = (*path, word), "write a register that is free"
    if place.is_bit and other.is_bit:
        if place.bit is None:
            return at, f"{word} {register} is {whose}", "write one that is free"
        return (*path, "bit"), f"bit {place.bit} of {word} {register} is {whose}", "write a bit that is free"
    if place.is_bit or other.is_bit:
        value = whose if place.is_bit else "a value, and bits of it"
        if place.is_bit:
            return at, f"{word} {register} holds the value {value}, and has no bits", free
        return at, f"{word} {register} has a bit of its own, {whose}, and holds no value", free
    if register > place.address:
        message = f"{place.type} takes {word} {place.address} and {register}, and {register} is {whose}"
        return at, message, "leave two registers for it, or give it a type of one"
    if register > other.address:
        message = f"{word} {register} is the second register of {whose}, which is {other.type}"
        return at, message, free
    return at, f"{word} {register} is {whose}", free
