"""Ends of motions that verbs began: each goes on, came to its end, or was ended by something else."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from hil.core import CoreAxis
from hil.sim.twin import Twin
from hil.vocab.axis import AxisState

BEGINS_NS = 20_000_000
"""Time after a verb within which its motion has begun: what a main program does begins with its next step."""


class BegunMotion(NamedTuple):
    """Motion that a verb began at a time. ``ends_after_ns`` and ``set_point``: as the verb answered; None: it
    did not say."""

    effective_at_ns: int
    ends_after_ns: float | None = None
    set_point: float | None = None

    def was_cut_short(self, device: Twin, axis: CoreAxis, state: AxisState, now_ns: int) -> bool | None:
        """True if something else has ended it; None while it goes on, as the axis's state tells."""
        if device.failed:
            return True
        if now_ns < self.effective_at_ns + BEGINS_NS or self._is_under_way(device, axis, state, now_ns):
            return None
        # What follows paths may be given set-points that it does not stand at; a stepper goes to each.
        if self.set_point is None or (self.ends_after_ns is None and device.follows_paths):
            return False
        stands_at = state.commanded_deg
        return stands_at is not None and abs(stands_at - self.set_point) > abs(self.set_point) * 1e-6 + 1e-4

    def _is_under_way(self, device: Twin, axis: CoreAxis, state: AxisState, now_ns: int) -> bool:
        """A path ends at the time that its verb told; the board's own ramps end when they do."""
        follows = device.follows_paths and axis.kind.follows_paths
        may_be = not follows or now_ns < self.effective_at_ns + (self.ends_after_ns or 0) + BEGINS_NS
        return device.is_busy or (may_be and state.is_under_way)


def begun_motion(effective_at_ns: int, answer: Mapping[str, Any]) -> BegunMotion:
    """Motion of a verb with its answer."""
    return BegunMotion(effective_at_ns, answer.get("ends_after_ns"), answer.get("set_point"))
