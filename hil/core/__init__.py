"""The facade over the native core: clock, groups, axes, events, snapshots.

``native/hil_core.h`` and ``docs/decisions/0001`` describe the native core and who may touch what.

May import: hil.vocab, the pure standard library.
"""

from hil.core.abi import WATCHES
from hil.core.axis_kind import AxisKind
from hil.core.core import Core
from hil.core.core_axis import CoreAxis
from hil.core.fields import FIELDS, Snapshot
from hil.core.kinds import KINDS

__all__ = [
    "FIELDS",
    "KINDS",
    "WATCHES",
    "AxisKind",
    "Core",
    "CoreAxis",
    "Snapshot",
]
