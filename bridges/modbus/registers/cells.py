"""Values in registers: how many each type takes, and their words, the high one first."""

from collections.abc import Mapping, MutableMapping
from math import isfinite
from struct import Struct

from bridges.modbus.protocol.pdu import Table
from hil.vocab.late_dataclass import dataclass

Halves = MutableMapping[int, int]
"""Holding registers that a client has written of values whose other registers it has not, by address."""


class WrittenWords:
    """Words of one write, completed with ``halves``, what the client wrote before; ``keep`` changes those."""

    def __init__(self, words: Mapping[int, int], halves: Halves) -> None:
        self._words, self._halves, self._known = words, halves, {**halves, **words}
        self._done: list[int] = []
        self._parts: dict[int, int] = {}

    def whole(self, addresses: range) -> tuple[int, ...] | None:
        """Words of a value; None: one of them was never written."""
        if all(address in self._known for address in addresses):
            self._done += addresses
            return tuple(self._known[address] for address in addresses)
        self._parts |= {address: self._words[address] for address in addresses if address in self._words}
        return None

    def keep(self) -> None:
        """Keep the words of the values that are not complete, and no more those of the others."""
        for address in self._done:
            self._halves.pop(address, None)
        self._halves.update(self._parts)


BIT = "bit"
_FORMATS = {
    "u16": "H",
    "i16": "h",
    "i32": "i",
    "u32": "I",
    "f32": "f",
    "i64": "q",
    "u64": "Q",
    "f64": "d",
}
_VALUES = {name: Struct(f">{code}") for name, code in _FORMATS.items()}
_WORDS = {name: Struct(f">{value.size // 2}H") for name, value in _VALUES.items()}
REGISTERS = {**{name: value.size // 2 for name, value in _VALUES.items()}, "i48": 3, "u48": 3, "text": 1}
"""Registers that a value of each type takes; a text has as many as its map says."""
_WITHOUT_FORMAT = ("i48", "u48")
I32_MIN, I32_MAX = -(2**31), 2**31 - 1
NO_I32 = I32_MIN
"""Content of an i32 that has no value, or whose parameter is left out."""


@dataclass(frozen=True)
class Cell:
    """Value at an address of a map. ``type``: bit, u16, i16, i32, u32, f32, i48, u48, i64, u64, f64 or
    text."""

    table: Table
    address: int
    type: str
    name: str
    unit: str
    about: str
    is_writable: bool = False
    count: int = 1
    """Number of such values from the address on."""

    @property
    def width(self) -> int:
        """Number of registers or bits."""
        return self.count * (1 if self.type == BIT else REGISTERS[self.type])


def words_of(type_name: str, value: float) -> tuple[int, ...]:
    """Words of a value, the high one first. A whole number out of the type's range becomes the nearest."""
    if type_name in _WITHOUT_FORMAT:
        low, high = limits(type_name)
        number = min(max(int(value), low), high) & 0xFFFF_FFFF_FFFF
        return number >> 32, number >> 16 & 0xFFFF, number & 0xFFFF
    code = _VALUES[type_name]
    if type_name in ("f32", "f64"):
        try:
            return _WORDS[type_name].unpack(code.pack(value))
        except OverflowError:  # a f64 that is no f32
            return _WORDS[type_name].unpack(code.pack(float("inf") if value > 0 else float("-inf")))
    low, high = limits(type_name)
    return _WORDS[type_name].unpack(code.pack(min(max(int(value), low), high)))


def limits(type_name: str) -> tuple[int, int]:
    """Smallest and largest number of a type of whole numbers."""
    bits, is_signed = REGISTERS[type_name] * 16, type_name.startswith("i")
    return (-(1 << bits - 1), (1 << bits - 1) - 1) if is_signed else (0, (1 << bits) - 1)


def value_of(type_name: str, words: tuple[int, ...]) -> float:
    """Value of words, the high one first. Of an f32 the shortest decimal number that has these words: who
    writes 90.1 means that, and not 90.0999985."""
    if type_name in _WITHOUT_FORMAT:
        number = words[0] << 32 | words[1] << 16 | words[2]
        return number - (1 << 48) if type_name == "i48" and number >> 47 else number
    value: float = _VALUES[type_name].unpack(_WORDS[type_name].pack(*words))[0]
    if type_name == "f32" and isfinite(value):
        shorter = (float(f"{value:.{digits}g}") for digits in range(6, 9))
        return next((short for short in shorter if words_of(type_name, short) == words), value)
    return value


def ordered(words: tuple[int, ...], is_low_first: bool) -> tuple[int, ...]:
    """Words in the order of a map, or back again."""
    return words[::-1] if is_low_first else words
