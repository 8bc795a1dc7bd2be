"""Needs of a Modbus node of a unit: the registers of one axis with their state."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from bridges.modbus.protocol.pdu import Span, Write
from bridges.modbus.registers.cells import Cell
from bridges.modbus.registers.control_word import Wanted
from bridges.modbus.registers.halves import Halves
from bridges.modbus.registers.register_unit import VerbStage
from hil.vocab.desk_protocol import AxisLook, DeviceInfo


class UnitMap(Protocol):
    """Map of a unit, for people and programs: what is where."""

    @property
    def info(self) -> DeviceInfo: ...

    @property
    def cells(self) -> Sequence[Cell]:
        """Registers and bits, in the order of tables and addresses."""

    @property
    def notes(self) -> Sequence[str]:
        """Things that are left out of it, with the reason."""

    @property
    def version(self) -> int:
        """Version of its layout or of its format."""

    @property
    def crc(self) -> int:
        """CRC-32 of the map, which is another when anything in it is."""

    @property
    def identity(self) -> Mapping[str, str]:
        """Texts of what the unit says that it is: vendor, product, revision; those that are not its own are
        left out."""


class Registers(Protocol):
    """Registers of an axis, as ``RegisterUnit``: it answers values, and what a write asks of the
    axis. The owner of the axis carries that out, and tells it the result."""

    @property
    def map(self) -> UnitMap: ...

    def needs_look(self, span: Span) -> bool:
        """True if registers or bits of a span have the present state of the axis."""

    def read(self, span: Span, look: AxisLook | None, halves: Mapping[int, int]) -> Sequence[int]:
        """Read registers or bits. ``look``: the axis now, if ``needs_look``. Raises Refused."""

    def check(self, span: Span) -> None:
        """Check that all of a span is there. Raises Refused."""

    def write(self, write: Write, halves: Halves) -> list[Wanted]:
        """Take registers or coils; answers what is to be done. Raises Refused: nothing was taken."""

    def note(self, wanted: Wanted, stage: VerbStage) -> None:
        """Note how a verb does that a write started."""
