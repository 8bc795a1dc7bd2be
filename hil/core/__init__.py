"""The facade over the native core: clock, groups, axes, events, snapshots.

What the native core is and who may touch what: ``native/hil_core.h`` and ``docs/decisions/0001``.

May import: hil.vocab, the pure standard library.
"""

from hil.core._native import WATCHES
from hil.core.core import Core, CoreAxis, CoreMotion
from hil.core.fields import FIELDS, Snapshot

__all__ = ["FIELDS", "WATCHES", "Core", "CoreAxis", "CoreMotion", "Snapshot"]
