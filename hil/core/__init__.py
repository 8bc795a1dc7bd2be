"""The facade over the native core: clock, groups, axes, events, snapshots.

What the native core is and who may touch what: ``native/hil_core.h`` and ``docs/decisions/0001``.

May import: hil.vocab, the pure standard library.
"""

from hil.core._native import WATCHES
from hil.core.core import (
    AXIS_PARAMETERS,
    AXIS_PINS,
    CLOCK_IN,
    CLOCK_OUT,
    CLOCK_OUT_HZ,
    FULL_PARAMETERS,
    MAX_WIRES,
    AxisPlan,
    Core,
    CoreAxis,
    CoreMotion,
    Load,
)
from hil.core.fields import FIELDS, Field, Snapshot

__all__ = [
    "AXIS_PARAMETERS",
    "AXIS_PINS",
    "CLOCK_IN",
    "CLOCK_OUT",
    "CLOCK_OUT_HZ",
    "FIELDS",
    "FULL_PARAMETERS",
    "MAX_WIRES",
    "WATCHES",
    "AxisPlan",
    "Core",
    "CoreAxis",
    "CoreMotion",
    "Field",
    "Load",
    "Snapshot",
]
