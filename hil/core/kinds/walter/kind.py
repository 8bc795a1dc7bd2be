"""A joint: all that hil asks of it."""

from hil.core._native import axis_bytes
from hil.core.abi import Kind, Law, WalterCall
from hil.core.axis_kind import ANGLE, AROUND, LOAD, MOTOR, AxisKind, Settable
from hil.core.core_axis import CoreAxis
from hil.core.fields import Snapshot, fields_of
from hil.vocab.axis import AxisState
from hil.vocab.faults import BUS_PART, SERVO, SHAFT
from hil.vocab.firmware import JOINT

_WALTER_CALLS = {name: int(call) for name, call in WalterCall.__members__.items()}


class CoreJoint(CoreAxis):
    """Joint of an arm; a firmware sees it as ``hil.vocab.firmware.ArmJoint``."""

    def loop(self, on: bool) -> None:
        """Stop the main loop where a control loop would be stopped."""
        if not on:
            self.do("stop")

    def do(self, call: str, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> float:
        return self._native.do(self.id, _WALTER_CALLS[call], x, y, z)


def _joint_motion(said: Snapshot) -> AxisState:
    is_stepping = said.step_interval_us > 0
    return AxisState(
        at_ns=said.at_ns,
        commanded_deg=said.to_be_deg,
        position_deg=said.position_deg,
        is_moving=said.ramp_left_ms > 0 or is_stepping,
        is_under_way=said.ramp_left_ms > 0 or is_stepping,
        is_on=bool(said.is_enabled and (said.is_powered or not said.has_driver)),
    )


KIND = AxisKind(
    title="joint",
    law=Law.walter,
    inputs={},
    outputs={},
    parameters=(
        *MOTOR,
        "phase_current_A",
        "gear_ratio",
        "driver_microsteps",
        "counts_backwards",
        "encoder_null_deg",
        "encoder_offset_deg",
    ),
    fields=fields_of(Kind.joint),
    default_signals=("to_be_deg", "measured_deg", "position_deg"),
    fault_targets=frozenset({SHAFT, SERVO, BUS_PART}),
    follows_paths=False,
    course=("to_be_deg", "position_deg"),
    motion=_joint_motion,
    max_current_A=lambda parameters: parameters["phase_current_A"],
    current_parameter="phase_current_A",
    memory_bytes=axis_bytes(Law.walter),
    settable={
        LOAD: AROUND,
        "knob_counts": Settable(0.0, 1023.0, is_around=True),
        "has_lights": Settable(0.0, 1.0, is_around=True),
        ANGLE: AROUND,
    },
    board_angles=("to_be_deg", "measured_deg"),
    own_faults={"bus_no_answer": {"noise_seed": "seed", "silent_rate": "rate"}},
    make=CoreJoint,
    seen_as=JOINT,
)
