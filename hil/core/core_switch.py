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
        """True while the axis holds it, bounces apart; whatever its contact does to a pin."""
        return bool(self.native.switch_is_active(self.axis, self.number))
