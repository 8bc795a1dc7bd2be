"""What a Modbus node needs of a unit: the registers of one axis with their state."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from hil.registers.control_word import Wanted
from hil.registers.register_unit import Halves, VerbStage
from hil.vocab.desk_protocol import AxisLook
from hil.wire.modbus.pdu import Mask, Span, Write


class Registers(Protocol):
    """Registers of an axis, as ``hil.registers.register_unit.RegisterUnit``: it answers values, and what a
    write asks of the axis. Whoever has the axis carries that out, and tells it how it went."""

    def needs_look(self, span: Span) -> bool:
        """True if registers or bits of a span tell of the axis, as it is now."""

    def read(self, span: Span, look: AxisLook | None, halves: Mapping[int, int]) -> Sequence[int]:
        """Read registers or bits. ``look``: the axis now, if ``needs_look``. Raises Refused."""

    def check(self, span: Span) -> None:
        """Check that all of a span is there. Raises Refused."""

    def write(self, write: Write, halves: Halves) -> list[Wanted]:
        """Take registers or coils; answers what is to be done. Raises Refused: nothing was taken."""

    def masked(self, mask: Mask, look: AxisLook | None, halves: Mapping[int, int]) -> Write:
        """Write that a mask makes of a holding register. Raises Refused: it is not there."""

    def note(self, wanted: Wanted, stage: VerbStage) -> None:
        """Note how a verb does that a write started."""
