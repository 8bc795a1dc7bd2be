"""Watch over an axis under power: faults of its board, the following error, the limit switches."""

from typing import NamedTuple

from bridges.can.canopen.cia402.drive_context import DriveContext
from bridges.can.canopen.cia402.error_codes import DriveError
from bridges.can.canopen.cia402.operating_mode import OperatingMode, TimeWindow


class FoundFault(NamedTuple):
    """Fault that was found: its error code, and what it is in words."""

    code: int
    why: str


class DriveWatch:
    """Watch of one drive. ``looked_ns``: when it looked last."""

    def __init__(self, context: DriveContext) -> None:
        self.looked_ns = 0
        self._context = context
        self._following = TimeWindow()
        self._is_blocked = False

    def begin(self, now_ns: int) -> None:
        """Begin with an axis that has just been told something new."""
        self.looked_ns = now_ns
        self._is_blocked = False
        self._following.clear()

    def look(self, mode: OperatingMode, now_ns: int, *, obeys_switches: bool) -> FoundFault | None:
        """Look for a fault; if there is none, stop a motion towards an active limit switch, once."""
        context = self._context
        look = context.look(now_ns)
        self.looked_ns = now_ns
        if look.fault_code:
            return FoundFault(look.fault_code, "the board reports a fault")
        if not look.is_on:
            return FoundFault(DriveError.LOOP_OFF, "the board's loop is off")
        if mode.checks_position:
            context.mover.check(look)
            off_deg = abs(context.off_deg(look, now_ns))
            is_off = off_deg > context.following_deg
            if self._following.holds(is_off, context.following_ns, now_ns):
                return FoundFault(DriveError.FOLLOWING, f"{off_deg:.3g} deg from the set-point")
        if obeys_switches and look.inputs and mode.obeys_limits:
            self._look_ahead(mode, now_ns)
        return None

    def _look_ahead(self, mode: OperatingMode, now_ns: int) -> None:
        context = self._context
        is_blocked = context.is_blocked(context.mover.where(now_ns).rate, now_ns)
        if is_blocked:
            if not self._is_blocked:
                mode.block(now_ns)
            context.is_limited = True
        self._is_blocked = is_blocked
