"""A servo: all that hil asks of it."""

from fractions import Fraction

from hil.core._native import axis_bytes
from hil.core.abi import Kind, Law, ServoCall, ServoInput
from hil.core.axis_kind import ANGLE, AROUND, LOAD, MOTOR, AxisKind, Settable, numbers
from hil.core.core_axis import CoreAxis
from hil.core.fields import INDEX, Snapshot, fields_of
from hil.vocab.axis import TURNS_RPM, AxisState
from hil.vocab.faults import SERVO, SHAFT
from hil.vocab.firmware import SERVO_LOOP
from hil.vocab.time import SimTimeNs

FULL_SCALE_V = 0.33
"""Full scale of the current command, at the driver's sense resistor: 3.3 V / 10."""
ANGLES = (ord("x"), ord("h"))
"""Modes whose set-point is an angle."""
_REGISTER = Settable(0.0, float(0x7FFF), is_around=True)
_AT, _LOOP_ON, _FOLLOWING, _MODE, _R, _YW, _VELOCITY = (
    INDEX[name] for name in ("at_ns", "loop_on", "following", "mode", "r", "yw", "velocity_rpm")
)


_SERVO_CALLS = {name: int(call) for name, call in ServoCall.__members__.items()}


class CoreServo(CoreAxis):
    """Servo; a firmware sees it as ``hil.vocab.firmware.ServoAxis``."""

    def do(self, call: str, value: float = 0.0) -> float:
        return self._native.do(self.id, _SERVO_CALLS[call], value, 0.0, 0.0)


def _servo_motion(said: Snapshot) -> AxisState:
    values = said.values  # faster than by their names: a drive is looked at at each SYNC
    is_on, follows = bool(values[_LOOP_ON]), bool(values[_FOLLOWING])
    is_angle = values[_MODE] in ANGLES
    return AxisState(
        at_ns=SimTimeNs(int(values[_AT])),
        commanded_deg=values[_R],
        position_deg=values[_YW],
        is_moving=follows or (is_on and not is_angle and abs(values[_VELOCITY]) > TURNS_RPM),
        is_under_way=follows,
        is_on=is_on,
        keeps_angle=is_on and is_angle,
    )


KIND = AxisKind(
    title="servo",
    law=Law.mechaduino,
    inputs=numbers(ServoInput),
    outputs={},
    parameters=(*MOTOR, "sense_resistor_ohm"),
    optional_parameters=("ambient_degC",),
    fields=fields_of(Kind.servo),
    default_signals=("r", "yw", "u"),
    fault_targets=frozenset({SHAFT, SERVO}),
    follows_paths=True,
    course=("r", "yw"),
    motion=_servo_motion,
    max_current_A=lambda parameters: FULL_SCALE_V / parameters["sense_resistor_ohm"],
    is_at_limit=lambda shot: bool(shot["loop_on"]) and shot["U"] >= shot["uMAX"] > 0,
    steps_per_turn=200,  # native/control/mechaduino.h: 50 poles
    current_parameter="sense_resistor_ohm",
    memory_bytes=axis_bytes(Law.mechaduino),
    settable={
        LOAD: AROUND,
        "diaagc": _REGISTER,
        "errfl": _REGISTER,
        ANGLE: AROUND,
        **dict.fromkeys(("pKp", "pKi", "pKd", "pLPF", "vKp", "vKi", "vKd", "vLPF"), Settable()),
        "PA": Settable(-360.0, 360.0),
        "uMAX": Settable(0.0, 255.0),
    },
    board_angles=("yw", "y", "r"),
    encoder_counts=16384,
    control_step_ns=Fraction(7385 * 10**9, 48_000_000),  # native/control/mechaduino.h
    make=CoreServo,
    seen_as=SERVO_LOOP,
)
