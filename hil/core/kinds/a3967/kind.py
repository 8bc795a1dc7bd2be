"""A step/dir driver: all that hil asks of it."""

from hil.core._native import axis_bytes
from hil.core.abi import DriverInput, Kind, Law
from hil.core.axis_kind import ANGLE, AROUND, LOAD, MOTOR, AxisKind, numbers
from hil.core.core_axis import CoreAxis
from hil.core.fields import Snapshot, fields_of
from hil.vocab.axis import AxisState
from hil.vocab.faults import SHAFT


def _driver_motion(said: Snapshot) -> AxisState:
    return AxisState(
        at_ns=said.at_ns,
        commanded_deg=said.commanded_deg,
        position_deg=said.position_deg,
        is_moving=False,  # pulses come from elsewhere: it knows of none to come
        is_under_way=False,
        is_on=bool(said.outputs_on),
    )


KIND = AxisKind(
    title="step/dir driver",
    law=Law.a3967,
    inputs=numbers(DriverInput),
    outputs={},
    parameters=(*MOTOR, "phase_current_A", "ambient_degC", "fast_decay_pct"),
    fields=fields_of(Kind.driver),
    default_signals=("commanded_deg", "position_deg", "lag_steps"),
    fault_targets=frozenset({SHAFT}),
    follows_paths=False,
    course=("commanded_deg", "position_deg"),
    motion=_driver_motion,
    max_current_A=lambda parameters: parameters["phase_current_A"],
    driver_A=lambda parameters: 0.75,  # data sheet
    current_parameter="phase_current_A",
    memory_bytes=axis_bytes(Law.a3967),
    is_commanded=False,
    settable={LOAD: AROUND, ANGLE: AROUND},
    board_angles=("commanded_deg",),
    make=CoreAxis,
)
