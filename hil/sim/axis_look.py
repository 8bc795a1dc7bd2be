"""A look at an axis: its fields, its motion and its board's state at one simulated time."""

from hil.core import AxisKind, Snapshot
from hil.core.fields import packed
from hil.sim.twin import Twin
from hil.vocab.desk_protocol import AxisLook


def axis_look(device: Twin, kind: AxisKind, shot: Snapshot) -> AxisLook:
    """Look at an axis of a kind in a snapshot of now; ``device``: whose it is."""
    return AxisLook(packed(shot.values), kind.motion(shot), device.failed, dict(device.told))
