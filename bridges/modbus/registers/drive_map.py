"""Map of a Modbus drive: where each value and bit of a drive is, as its maker's manual has them.

The text of such a map is read by ``bridges.modbus.maps.drive_map_text``.
"""

from collections.abc import Mapping
from dataclasses import field, replace
from math import isfinite

from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.cells import BIT, REGISTERS, limits, ordered, value_of, words_of
from bridges.modbus.registers.map_parts import (
    NO_MOVES,
    USUAL,
    BlockPart,
    CellPart,
    CommandPart,
    Conversion,
    Look,
    Manners,
    MovesPart,
    StatePart,
)
from hil.vocab.late_dataclass import dataclass

TYPES = ("u16", "i16", "u32", "i32", "f32")
"""Types of values in registers."""
WIDE_TYPES = ("u48", "i48", "u64", "i64", "f64", "text")
"""Types of values in a map of version 2 beside those."""
_EXACT = ("u48", "i48", "u64", "i64", "text")
_FLOATS = ("f32", "f64")
IDENTITY = ("vendor", "product", "revision")
"""Texts of what a drive says that it is, in the order of the objects of function 43/14."""
STATUS = {
    "enabled": "the loop is on and holds the shaft",
    "moving": "a move is under way, or a set-point is followed that still changes",
    "fault": "the drive has a fault, and its loop is off",
}
"""Bits that a drive tells, with their meanings."""
CONTROL = {
    "enable": "1: the loop is on; 0: it is off",
    "start": "when it becomes 1: move to the set-point by the drive's own ramps",
    "stop": "when it becomes 1: stop by the drive's own ramp",
    "reset": "when it becomes 1: clear the fault",
    "follow": "while it is 1, the set-point is followed at once",
}
"""Bits that a drive takes, with their meanings."""
COMMANDS = ("start", "stop", "reset")
"""Those of them that start something, and mean nothing while they stay as they are."""


@dataclass(frozen=True)
class RegisterPlace:
    """Place of a value or a bit. ``type``: one of ``TYPES`` or ``WIDE_TYPES``, or bit; ``scale``: factor from
    the number in the registers to the value; ``bit``: of a register, from 0 on; None: a value, or a bit of a
    table of bits; ``on_write``: each write of 1 is a command, and the bit clears itself.

    Of version 2: ``mask``: bits of a register that have a number; ``count``: registers of a text;
    ``low_first``: order of the words, None: the map's; ``conversion``: beside the scale.
    """

    table: Table
    address: int
    type: str = "u16"
    scale: float = 1.0
    bit: int | None = None
    on_write: bool = False
    mask: int | None = None
    count: int = 1
    low_first: bool | None = None
    conversion: Conversion | None = None

    @property
    def width(self) -> int:
        """Number of registers, or 1 of a table of bits."""
        return 1 if self.type == BIT else REGISTERS[self.type] * self.count

    @property
    def is_bit(self) -> bool:
        """True if there is a bit, and no value."""
        return self.type == BIT

    @property
    def bits(self) -> int | None:
        """Bits that it has of its register; None: all, or a bit of a table of bits."""
        return self.mask if self.mask is not None else None if self.bit is None else 1 << self.bit

    def resolved(self, look: Look) -> "RegisterPlace":
        """Place with the numbers of the cells that it looks at."""
        if self.conversion is None or not self.conversion.names:
            return self
        return replace(self, conversion=self.conversion.resolved(look))

    def value(self, words: tuple[int, ...], *, is_low_first: bool = False) -> float:
        """Value of its registers' words, in the order of their addresses."""
        words = ordered(words, is_low_first if self.low_first is None else self.low_first)
        if self.type == "text":
            return text_number(words)
        number = value_of(self.type, words)
        if self.mask is not None:
            number = (int(number) & self.mask) >> lowest_bit(self.mask)
        if self.conversion is not None:
            return self.conversion.value(number * self.scale)
        if self.type in _EXACT and self.scale == 1:
            return number
        # 57 * 0.01 is 0.5700000000000001, and 57 / 100 what the register means.
        per_unit = round(1 / self.scale) if abs(self.scale) < 1 else 0
        is_fraction = per_unit and 1 / per_unit == self.scale
        return (number / per_unit if is_fraction else number * self.scale) + 0.0  # no -0.0

    def words(self, value: float, *, is_low_first: bool = False) -> tuple[int, ...]:
        """Words of a value, in the order of their addresses; of one that the type cannot hold those of the
        nearest. Of one with a mask, its own bits alone. ``value``: finite, or infinite where a time of 0
        means that."""
        order = is_low_first if self.low_first is None else self.low_first
        if self.type == "text":
            return ordered(_text_words(int(value), self.count), order)
        number = self._number(value)
        if self.type not in _FLOATS:
            low, high = self._limits
            number = round(min(max(number, low), high))
        if self.mask is not None:
            return ((int(number) << lowest_bit(self.mask) & self.mask),)
        return ordered(words_of(self.type, number), order)

    def holds(self, value: float) -> bool:
        """True if the registers can hold a value, rounded to a step of ``scale``."""
        if not isfinite(value):
            return False
        if self.type == "f32":
            return isfinite(value_of("f32", words_of("f32", self._number(value))))
        if self.type in ("f64", "text"):
            return True
        low, high = self._limits
        number = self._number(value)
        return isfinite(number) and low <= round(number) <= high

    @property
    def _limits(self) -> tuple[int, int]:
        if self.mask is not None:
            return 0, self.mask >> lowest_bit(self.mask)
        return limits(self.type)

    def _number(self, value: float) -> float:
        if self.type in _EXACT and self.scale == 1 and self.conversion is None:
            return value
        return (value if self.conversion is None else self.conversion.scaled(value)) / self.scale + 0.0


def lowest_bit(mask: int) -> int:
    """Number of a mask's lowest bit."""
    return (mask & -mask).bit_length() - 1


def text_number(words: tuple[int, ...]) -> int:
    """Number that stands for a text of registers: its bytes, the first one highest."""
    return int.from_bytes(b"".join(word.to_bytes(2, "big") for word in words), "big")


def _text_words(number: int, count: int) -> tuple[int, ...]:
    data = (number & (1 << 16 * count) - 1).to_bytes(2 * count, "big")
    return tuple(data[at] << 8 | data[at + 1] for at in range(0, 2 * count, 2))


@dataclass(frozen=True)
class MapParts:
    """Parts of a map of version 2. ``cells``, ``commands``, ``states``: by name, with their places;
    ``blocks``: by name; ``also``: further places of values; ``reserved``: registers that read as 0. What is
    in a block has addresses from ``BlockPart.base`` on, where no table has any."""

    cells: Mapping[str, tuple[RegisterPlace, CellPart]] = field(default_factory=dict)
    commands: Mapping[str, tuple[RegisterPlace, CommandPart]] = field(default_factory=dict)
    states: Mapping[str, tuple[RegisterPlace, StatePart]] = field(default_factory=dict)
    blocks: Mapping[str, BlockPart] = field(default_factory=dict)
    also: tuple[tuple[str, RegisterPlace], ...] = ()
    moves: MovesPart = NO_MOVES
    reserved: tuple[tuple[Table, int, int], ...] = ()
    """Tables, first addresses and numbers of registers."""
    manners: Manners = USUAL


NO_PARTS = MapParts()


@dataclass(frozen=True)
class DriveMap:
    """Map of a drive. ``word_order``: high_first or low_first, of values in two registers; the mappings are
    by the names of ``TOLD`` and ``TAKEN``, ``STATUS``, ``CONTROL``, and by those of fields of the axis."""

    word_order: str = "high_first"
    identity: Mapping[str, str] = field(default_factory=dict)
    """Texts of ``IDENTITY``, those that are given."""
    values: Mapping[str, RegisterPlace] = field(default_factory=dict)
    status: Mapping[str, RegisterPlace] = field(default_factory=dict)
    control: Mapping[str, RegisterPlace] = field(default_factory=dict)
    parameters: Mapping[str, RegisterPlace] = field(default_factory=dict)
    version: int = 1
    parts: MapParts = NO_PARTS
    """Parts that a map of version 2 has beside."""

    @property
    def has_angle(self) -> bool:
        """True if it can be sent to an angle; False: a drive that only turns, or no drive."""
        return self.version == 1 or "set_point_deg" in self.values or self.parts.moves.count > 0

    @property
    def is_low_first(self) -> bool:
        """True if the low word of a value in two registers comes first."""
        return self.word_order == "low_first"

    @property
    def places(self) -> Mapping[str, RegisterPlace]:
        """All places by their dotted names, as ``control.enable``."""
        rooms = {"status": self.status, "control": self.control, "parameters": self.parameters}
        named = {f"{room}.{name}": place for room, each in rooms.items() for name, place in each.items()}
        return {**self.values, **named}
