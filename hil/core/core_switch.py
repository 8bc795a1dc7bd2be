"""Switch at the shaft of an axis, as the core has it."""

from typing import NamedTuple

from hil.core._native import NativeCore


class CoreSwitch(NamedTuple):
    """Switch number ``number`` of an axis. The caller owns the group."""

    native: NativeCore
    axis: int
    number: int

    @property
    def is_active(self) -> bool:
        """True while the axis holds it, as its contact has it: bounces and faults are in it. From any
        thread."""
        return bool(self.native.switch_is_active(self.axis, self.number))

    def fault(self, held: int, shift_deg: float) -> None:
        """Set what is wrong with it. ``held``: ``CONTACT_OPEN``, ``CONTACT_CLOSED`` (``hil.core.abi``) or 0;
        ``shift_deg``: how much farther up it sits."""
        self.native.switch_fault(self.axis, self.number, held, shift_deg)
