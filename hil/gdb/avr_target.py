"""AVR as GDB sees it: registers by number, memories by address; and what is asked of a chip.

Source: gdb/avr-tdep.c of GDB 12 (names, sizes and numbers of registers; offsets of data space and EEPROM);
DS40002061, 7.4 and 7.5 (status register and stack pointer in data space).
"""

from collections.abc import Collection
from enum import Enum
from typing import NamedTuple, Protocol


class MemorySpace(Enum):
    """Memory of a chip."""

    FLASH = "flash"
    DATA = "data"
    EEPROM = "eeprom"


class _Room(NamedTuple):
    """Addresses of a memory for GDB."""

    first: int
    bytes: int
    space: MemorySpace


_ROOMS = (
    _Room(0, 0x8000, MemorySpace.FLASH),
    _Room(0x800000, 0x900, MemorySpace.DATA),
    _Room(0x810000, 0x400, MemorySpace.EEPROM),
)
SREG_AT, SP_AT, SP_BYTES = 0x5F, 0x5D, 2
REGISTERS, SREG, SP, PC = 32, 32, 33, 34
"""Number of the general registers, and numbers of the others."""
PC_BYTES = 4
VECTOR_BYTES, VECTORS = 4, 26
"""Size and number of interrupt vectors; the first is the reset's. Source: DS40002061, 12.4."""


class DebuggedChip(Protocol):
    """Chip that is debugged. It stands whenever it is looked at or written to."""

    def read(self, space: MemorySpace, at: int, count: int) -> bytes:
        """Bytes of a memory, without what reading them does in the chip."""

    def write(self, space: MemorySpace, at: int, data: bytes) -> None:
        """Write a memory. Raises ValueError: it cannot be."""

    @property
    def program_counter(self) -> int:
        """Byte address of its next instruction."""

    def jump(self, address: int) -> None:
        """Let it go on at another address."""

    def go(self, breakpoints: Collection[int], *, is_step: bool) -> None:
        """Let it run, until just before an instruction at one of these byte addresses; its first instruction
        it carries out in any case. ``is_step``: that one only. The session's ``stopped`` is called then,
        after this has returned."""

    def halt(self) -> None:
        """Stop it between two instructions, now."""

    def reset(self) -> None:
        """Reset it as its RESET pin does. It stands at its first instruction."""

    def words(self) -> str:
        """Line on its time, for people."""


def read_memory(chip: DebuggedChip, address: int, count: int) -> bytes:
    """Bytes from an address of GDB's on, fewer where the memory ends. Raises ValueError: there is none."""
    room = _room(address)
    at = address - room.first
    return chip.read(room.space, at, min(count, room.bytes - at))


def write_memory(chip: DebuggedChip, address: int, count: int, data: bytes) -> None:
    """Write ``count`` bytes. Raises ValueError: there is no such memory, it cannot be written, or it is
    other data."""
    if count == 0:
        return
    room = _room(address)
    if count != len(data) or address - room.first + count > room.bytes:
        raise ValueError("not all of it is in a memory")
    chip.write(room.space, address - room.first, data)


def _room(address: int) -> _Room:
    for room in _ROOMS:
        if room.first <= address < room.first + room.bytes:
            return room
    raise ValueError("no memory has this address")


def register(chip: DebuggedChip, number: int) -> bytes:
    """Content of a register, lowest byte first. Raises ValueError: there is none of this number."""
    if number == PC:
        return chip.program_counter.to_bytes(PC_BYTES, "little")
    at, count = _register_place(number)
    return chip.read(MemorySpace.DATA, at, count)


def all_registers(chip: DebuggedChip) -> bytes:
    return b"".join(register(chip, number) for number in range(PC + 1))


def set_register(chip: DebuggedChip, number: int, content: bytes) -> None:
    """Set a register. Raises ValueError: there is none of this number, or it cannot be set."""
    if number == PC:
        chip.jump(int.from_bytes(content, "little"))
        return
    at, count = _register_place(number)
    if len(content) != count:
        raise ValueError("a register of another size")
    chip.write(MemorySpace.DATA, at, content)


def set_all_registers(chip: DebuggedChip, content: bytes) -> None:
    for number in range(PC + 1):
        count = PC_BYTES if number == PC else _register_place(number)[1]
        set_register(chip, number, content[:count])
        content = content[count:]


def _register_place(number: int) -> tuple[int, int]:
    if 0 <= number < REGISTERS:
        return number, 1
    if number == SREG:
        return SREG_AT, 1
    if number == SP:
        return SP_AT, SP_BYTES
    raise ValueError("no such register")


def return_address(chip: DebuggedChip) -> int:
    """Byte address to which an interrupt returns that has just begun: the high byte stands below the low one.
    Source: DS40002061, 7.5.1."""
    stack_pointer = int.from_bytes(register(chip, SP), "little")
    return int.from_bytes(chip.read(MemorySpace.DATA, stack_pointer + 1, 2), "big") * 2
