"""The table of kinds of axis: all that hil asks of one, by the control law that a profile names.

Code that needs a thing which not every axis has asks the axis's row here, never which board it is.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum

from hil.core._native import axis_bytes
from hil.core.abi import (
    LIMIT_RPM,
    LIMIT_TEETH_RPM,
    BankPin,
    DriverInput,
    Kind,
    Law,
    Output,
    ServoInput,
    StepperInput,
)
from hil.core.fields import INDEX, Snapshot, fields_of
from hil.vocab.axis import AxisState
from hil.vocab.faults import BUS_PART, SERVO, SHAFT

CLOCK_OUT, CLOCK_IN, CLOCK_OUT_HZ = "clock", "xclk", 1_000_000
"""A stepper controller's clock output and its input for one: frequencies and not edges."""
FULL_SCALE_V = 0.33
"""Full scale of the Mechaduino's current command, at the driver's sense resistor: 3.3 V / 10."""
ANGLES = (ord("x"), ord("h"))
"""Modes of a servo whose set-point is an angle."""
TURNS_RPM = 5.0
"""Speed below which a shaft whose set-point is no angle stands: above the noise of a measured speed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class AxisKind:
    """Kind of axis, or of pins without a motor. Fields are names of ``hil.core.FIELDS``."""

    title: str
    """Word for the kind in messages."""
    law: Law
    """Control law that the native core runs."""
    inputs: Mapping[str, int]
    """Numbers of the kind's inputs by name; two names of one number are the same pin."""
    outputs: Mapping[str, int]
    has_clock: bool
    """True if the axis also gives and takes a clock (``CLOCK_OUT``, ``CLOCK_IN``)."""
    parameters: tuple[str, ...]
    """Numbers that a profile gives for its motor, driver and load; empty: there is no motor."""
    fields: Mapping[str, int]
    """Indices of the kind's fields in the table, by name."""
    default_signals: tuple[str, ...]
    """Fields that are drawn by default."""
    fault_targets: frozenset[str]
    """Kinds of target of ``hil.vocab.faults`` that it is: what can fail."""
    follows_paths: bool
    """True if the set-point follows paths; if not, the axis makes ramps of its own to the angles it is sent
    to."""
    course: tuple[str, ...]
    """Fields of the set-point and of the position, in degrees; empty without a motor."""
    motion: Callable[[Snapshot], AxisState]
    """Reads an axis's state as motion."""
    max_current_A: Callable[[Mapping[str, float]], float]
    """Maximum current of a coil, by its parameters."""
    memory_bytes: int
    """Locked memory in the core, of an axis that is alone in its group."""
    is_commanded: bool = True
    """True if its board's firmware moves it; if not, only what is at its pins does, or it has no motor."""

    def level_field(self, pin: str) -> str | None:
        """Field that tells the level of an input, by any of the input's names; None: none does."""
        same = (f"pin_{name.lower()}" for name, number in self.inputs.items() if number == self.inputs[pin])
        return next((name for name in same if name in self.fields), None)

    def holding_Nm(self, parameters: Mapping[str, float]) -> float:
        """Maximum torque of the motor, without that of its magnets; 0: there is none."""
        if not self.has_motor:
            return 0.0
        return parameters["torque_constant_Nm_per_A"] * self.max_current_A(parameters)

    @property
    def has_motor(self) -> bool:
        """True if it moves a motor; if not, it is the pins of a microcontroller."""
        return bool(self.parameters)


def speed_limit_rpm(parameters: Mapping[str, float]) -> float:
    """Maximum speed of a shaft, whatever drags it: the native core's, by the teeth of its rotor."""
    return min(LIMIT_RPM, LIMIT_TEETH_RPM / parameters.get("rotor_teeth", 1.0))


_LOOP_ON, _FOLLOWING, _MODE, _R, _YW, _VELOCITY = (
    INDEX[name] for name in ("loop_on", "following", "mode", "r", "yw", "velocity_rpm")
)


def _numbers(pins: type[IntEnum]) -> dict[str, int]:
    return {name: int(number) for name, number in pins.__members__.items()}


def _servo_motion(said: Snapshot) -> AxisState:
    values = said.values  # faster than by their names: a drive is looked at at each SYNC
    is_on, follows = bool(values[_LOOP_ON]), bool(values[_FOLLOWING])
    is_angle = values[_MODE] in ANGLES
    return AxisState(
        at_ns=said.at_ns,
        commanded_deg=values[_R],
        position_deg=values[_YW],
        is_moving=follows or (is_on and not is_angle and abs(values[_VELOCITY]) > TURNS_RPM),
        is_under_way=follows,
        is_on=is_on,
        keeps_angle=is_on and is_angle,
    )


def _stepper_motion(said: Snapshot) -> AxisState:
    return AxisState(
        at_ns=said.at_ns,
        commanded_deg=said.commanded_deg,
        position_deg=said.position_deg,
        is_moving=bool(said.motion_state),
        is_under_way=bool(said.motion_state or said.pending),
        is_on=True,
    )


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


def _driver_motion(said: Snapshot) -> AxisState:
    return AxisState(
        at_ns=said.at_ns,
        commanded_deg=said.commanded_deg,
        position_deg=said.position_deg,
        is_moving=False,  # pulses come from elsewhere: it knows of none to come
        is_under_way=False,
        is_on=bool(said.outputs_on),
    )


def _pin_bank_motion(said: Snapshot) -> AxisState:
    is_pulsing = bool(said.pulses_left)
    return AxisState(said.at_ns, None, None, is_moving=is_pulsing, is_under_way=is_pulsing, is_on=True)


_MOTOR = (
    "inertia_kg_m2",
    "viscous_Nm_s_per_rad",
    "torque_constant_Nm_per_A",
    "start_deg",
    "load_torque_Nm",
    "rotor_teeth",
)

MECHADUINO = AxisKind(
    title="servo",
    law=Law.mechaduino,
    inputs=_numbers(ServoInput),
    outputs={},
    has_clock=False,
    parameters=(*_MOTOR, "sense_resistor_ohm"),
    fields=fields_of(Kind.servo),
    default_signals=("r", "yw", "u"),
    fault_targets=frozenset({SHAFT, SERVO}),
    follows_paths=True,
    course=("r", "yw"),
    motion=_servo_motion,
    max_current_A=lambda parameters: FULL_SCALE_V / parameters["sense_resistor_ohm"],
    memory_bytes=axis_bytes(Law.mechaduino),
)
"""A closed loop with an encoder, driven by step and direction or by set-points."""

SAC = AxisKind(
    title="stepper",
    law=Law.sac,
    inputs=_numbers(StepperInput),
    outputs=_numbers(Output),
    has_clock=True,
    parameters=(*_MOTOR, "phase_current_A", "driver"),
    fields=fields_of(Kind.stepper),
    default_signals=("speed_rpm", "commanded_deg", "position_deg"),
    fault_targets=frozenset({SHAFT}),
    follows_paths=False,
    course=("commanded_deg", "position_deg"),
    motion=_stepper_motion,
    max_current_A=lambda parameters: parameters["phase_current_A"],
    memory_bytes=axis_bytes(Law.sac),
)
"""A motion engine that makes step pulses for a driver, without an encoder."""

WALTER = AxisKind(
    title="joint",
    law=Law.walter,
    inputs={},
    outputs={},
    has_clock=False,
    parameters=(
        *_MOTOR,
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
    memory_bytes=axis_bytes(Law.walter),
)
"""A joint that pulses turn through a gear, or a servo at once; a board has several, and one main loop."""

A3967 = AxisKind(
    title="step/dir driver",
    law=Law.a3967,
    inputs=_numbers(DriverInput),
    outputs={},
    has_clock=False,
    parameters=(*_MOTOR, "phase_current_A", "ambient_degC", "fast_decay_pct"),
    fields=fields_of(Kind.driver),
    default_signals=("commanded_deg", "position_deg", "lag_steps"),
    fault_targets=frozenset({SHAFT}),
    follows_paths=False,
    course=("commanded_deg", "position_deg"),
    motion=_driver_motion,
    max_current_A=lambda parameters: parameters["phase_current_A"],
    memory_bytes=axis_bytes(Law.a3967),
    is_commanded=False,
)
"""A driver that steps by its pins, and its motor, without an encoder."""

PIN_BANK = AxisKind(
    title="pins",
    law=Law.pin_bank,
    inputs=_numbers(BankPin),
    outputs=_numbers(BankPin),
    has_clock=False,
    parameters=(),
    fields=fields_of(Kind.pin_bank),
    default_signals=("pin_levels",),
    fault_targets=frozenset(),
    follows_paths=False,
    course=(),
    motion=_pin_bank_motion,
    max_current_A=lambda parameters: 0.0,
    memory_bytes=axis_bytes(Law.pin_bank),
    is_commanded=False,
)
"""Pins of a microcontroller, each an input or an output, and no motor."""

KINDS: Mapping[str, AxisKind] = {kind.law.name: kind for kind in (MECHADUINO, SAC, WALTER, A3967, PIN_BANK)}
"""Kinds of axis by their laws' names in ``profile.yaml``."""
