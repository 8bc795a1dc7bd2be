"""A magnetic encoder on another axis's shaft: all that hil asks of it."""

from hil.core._native import axis_bytes
from hil.core.abi import Kind, Law, SpiInput, SpiOutput
from hil.core.axis_kind import AxisKind, Settable, numbers
from hil.core.core_axis import CoreAxis
from hil.core.fields import Snapshot, fields_of
from hil.vocab.axis import AxisState
from hil.vocab.faults import SERVO


def _encoder_motion(said: Snapshot) -> AxisState:
    return AxisState(said.at_ns, None, None, is_moving=False, is_under_way=False, is_on=True)


_REGISTER = Settable(0.0, float(0x3FFF), is_around=True)

KIND = AxisKind(
    title="encoder",
    law=Law.as5047d,
    inputs=numbers(SpiInput),
    outputs=numbers(SpiOutput),
    parameters=(),
    fields=fields_of(Kind.encoder_chip, has_motor=False),
    default_signals=("raw",),
    fault_targets=frozenset({SERVO}),
    follows_paths=False,
    course=(),
    motion=_encoder_motion,
    max_current_A=lambda parameters: 0.0,
    memory_bytes=axis_bytes(Law.as5047d),
    is_commanded=False,
    settable={"diaagc": _REGISTER, "errfl": _REGISTER},
    make=CoreAxis,
    open_outputs=frozenset({"MISO"}),
    reads_magnet=True,
)
