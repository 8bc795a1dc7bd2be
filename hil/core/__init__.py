"""The facade over the native core: clock, groups, axes, events, snapshots.

``native/hil_core.h`` and ``docs/decisions/0001`` describe the native core and who may touch what.

May import: hil.vocab, the pure standard library.
"""

from hil.core.abi import WATCHES
from hil.core.core import Core, CoreAxis, CoreBank, CoreMotion
from hil.core.fields import FIELDS, Snapshot
from hil.core.kinds import KINDS, AxisKind

__all__ = [
    "FIELDS",
    "KINDS",
    "WATCHES",
    "AxisKind",
    "Core",
    "CoreAxis",
    "CoreBank",
    "CoreMotion",
    "Snapshot",
]
