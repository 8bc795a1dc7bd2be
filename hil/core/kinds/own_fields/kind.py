"""A board without a motor, whose fields are its own: all that hil asks of it."""

from hil.core._native import axis_bytes
from hil.core.abi import Kind, Law
from hil.core.axis_kind import AxisKind
from hil.core.core_axis import CoreAxis
from hil.core.fields import Snapshot, fields_of
from hil.vocab.axis import AxisState


def _still(said: Snapshot) -> AxisState:
    return AxisState(said.at_ns, None, None, is_moving=False, is_under_way=False, is_on=True)


KIND = AxisKind(
    title="fields",
    law=Law.own_fields,
    inputs={},
    outputs={},
    parameters=(),
    fields=fields_of(Kind.own_fields, has_motor=False),
    default_signals=(),
    fault_targets=frozenset(),
    follows_paths=False,
    course=(),
    motion=_still,
    max_current_A=lambda parameters: 0.0,
    memory_bytes=axis_bytes(Law.own_fields),
    is_commanded=False,
    settable={},
    make=CoreAxis,
)
