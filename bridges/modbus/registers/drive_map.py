"""Map of a Modbus drive: where each value and bit of a drive is, as its maker's manual has them.

The text of such a map is read by ``bridges.modbus.maps.drive_map_text``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite

from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.cells import BIT, limits, ordered, value_of, words_of

TYPES = ("u16", "i16", "u32", "i32", "f32")
"""Types of values in registers."""
_OF_TWO = ("u32", "i32", "f32")
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
    """Place of a value or a bit. ``type``: one of ``TYPES``, or bit; ``scale``: factor from the number in the
    registers to the value; ``bit``: of a register, from 0 on; None: a value, or a bit of a table of bits;
    ``on_write``: each write of 1 is a command, and the bit clears itself."""

    table: Table
    address: int
    type: str = "u16"
    scale: float = 1.0
    bit: int | None = None
    on_write: bool = False

    @property
    def width(self) -> int:
        """Number of registers, or 1 of a table of bits."""
        return 2 if self.type in _OF_TWO else 1

    @property
    def is_bit(self) -> bool:
        """True if there is a bit, and no value."""
        return self.type == BIT

    def value(self, words: tuple[int, ...], *, is_low_first: bool = False) -> float:
        """Value of its registers' words, in the order of their addresses."""
        number = value_of(self.type, ordered(words, is_low_first))
        # 57 * 0.01 is 0.5700000000000001, and 57 / 100 what the register means.
        per_unit = round(1 / self.scale) if abs(self.scale) < 1 else 0
        is_fraction = per_unit and 1 / per_unit == self.scale
        return (number / per_unit if is_fraction else number * self.scale) + 0.0  # no -0.0

    def words(self, value: float, *, is_low_first: bool = False) -> tuple[int, ...]:
        """Words of a value, in the order of their addresses; of one that the type cannot hold those of the
        nearest. ``value``: finite."""
        number = value / self.scale + 0.0
        if self.type != "f32":
            low, high = limits(self.type)
            number = round(min(max(number, low), high))
        return ordered(words_of(self.type, number), is_low_first)

    def holds(self, value: float) -> bool:
        """True if the registers can hold a value, rounded to a step of ``scale``."""
        if not isfinite(value):
            return False
        if self.type == "f32":
            return isfinite(value_of("f32", words_of("f32", value / self.scale)))
        low, high = limits(self.type)
        number = value / self.scale
        return isfinite(number) and low <= round(number) <= high


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
