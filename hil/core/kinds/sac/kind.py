"""A stepper: all that hil asks of it."""

from hil.core._native import axis_bytes
from hil.core.abi import Kind, Law, Output, StepperInput
from hil.core.axis_kind import ANGLE, AROUND, LOAD, MOTOR, AxisKind, Settable, numbers
from hil.core.fields import Snapshot, fields_of
from hil.core.kinds.sac.core_motion import CoreMotion
from hil.vocab.axis import AxisState
from hil.vocab.faults import SHAFT
from hil.vocab.firmware import MOTION


def _stepper_motion(said: Snapshot) -> AxisState:
    return AxisState(
        at_ns=said.at_ns,
        commanded_deg=said.commanded_deg,
        position_deg=said.position_deg,
        is_moving=bool(said.motion_state),
        is_under_way=bool(said.motion_state or said.pending),
        is_on=True,
    )


KIND = AxisKind(
    title="stepper",
    law=Law.sac,
    inputs=numbers(StepperInput),
    outputs=numbers(Output),
    parameters=(*MOTOR, "phase_current_A", "driver"),
    fields=fields_of(Kind.stepper),
    default_signals=("speed_rpm", "commanded_deg", "position_deg"),
    fault_targets=frozenset({SHAFT}),
    follows_paths=False,
    course=("commanded_deg", "position_deg"),
    motion=_stepper_motion,
    max_current_A=lambda parameters: parameters["phase_current_A"],
    driver_A=lambda parameters: 2.5 if parameters["driver"] else 2.0,  # data sheets of DRV8825 and A4988
    current_parameter="phase_current_A",
    memory_bytes=axis_bytes(Law.sac),
    settable={LOAD: AROUND, ANGLE: AROUND, "clock_Hz": Settable(-1.0, 1e9)},
    board_angles=("commanded_deg",),
    commanded_rpm="speed_rpm",
    clock_field="clock_Hz",
    make=CoreMotion,
    seen_as=MOTION,
)
