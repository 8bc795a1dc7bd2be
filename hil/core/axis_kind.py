"""Form of a kind of axis: all that hil asks of one.

Code that needs a thing which not every axis has asks the axis's kind here, never which board it is.
"""

from collections.abc import Callable, Mapping
from dataclasses import field
from enum import IntEnum
from fractions import Fraction
from typing import Any

from hil.core._native import NativeCore
from hil.core.abi import LIMIT_RPM, LIMIT_TEETH_RPM, Law
from hil.core.fields import TABLE, Field, Snapshot
from hil.vocab.axis import AxisState
from hil.vocab.late_dataclass import dataclass
from hil.vocab.own_fields import OwnField

CLOCK_OUT, CLOCK_IN, CLOCK_OUT_HZ = "clock", "xclk", 1_000_000
"""A controller's clock output and its input for one: frequencies and not edges."""
ANGLE = "position_deg"
"""Angle of the shaft as it is told: setting it sets its zero, and turns nothing."""
LOAD = "load_torque_Nm"
"""Load torque on the shaft; what the motor holds says how much is allowed."""
MOTOR = (
    "inertia_kg_m2",
    "viscous_Nm_s_per_rad",
    "torque_constant_Nm_per_A",
    "start_deg",
    LOAD,
    "rotor_teeth",
)
"""Parameters of every motor."""


class NoRoom(ValueError):
    """Error of fields for which an axis has no place: ``name`` is the first."""

    def __init__(self, name: str, room: int) -> None:
        super().__init__(f"there is no room for {name}: this board can have {room} such fields")
        self.name, self.room = name, room


@dataclass(frozen=True)
class Settable:
    """Range of a field that may be set from outside. ``is_around``: it is the world around the board, and not
    the firmware's memory."""

    low: float = -1e6
    high: float = 1e6
    is_around: bool = False


AROUND = Settable(is_around=True)


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
    parameters: tuple[str, ...]
    """Numbers that a profile gives for its motor, driver and load; empty: there is no motor."""
    optional_parameters: tuple[str, ...] = ()
    """Numbers that a profile may give, or leave out."""
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
    settable: Mapping[str, Settable]
    """Fields that may be set from outside, by whatever way: commands, bridges, faults."""
    max_current_A: Callable[[Mapping[str, float]], float]
    """Maximum current of a coil, by its parameters."""
    memory_bytes: int
    """Locked memory in the core, of an axis that is alone in its group."""
    is_at_limit: Callable[[Mapping[str, float]], bool] = lambda shot: False
    """Answers by an axis's fields whether its law gives its whole effort."""
    driver_A: Callable[[Mapping[str, float]], float] | None = None
    """Maximum current of a coil that its driver can be set to; None: ``max_current_A`` is all it gives."""
    steps_per_turn: int = 0
    """Full steps in a turn of the motors that its law commutates; 0: of any."""
    current_parameter: str = ""
    """Parameter that this current goes by; empty: there is no motor."""
    is_commanded: bool = True
    """True if its board's firmware moves it; if not, only what is at its pins does, or it has no motor."""
    board_angles: tuple[str, ...] = ()
    """Fields of angles by the board's own zero, first where the board has the axis; ``ANGLE`` has another."""
    commanded_rpm: str = ""
    """Field of the speed that it is to have; empty: none tells."""
    encoder_counts: int = 0
    """Counts in a turn of the encoder by which its board knows the angle, with a look-up table
    (``CoreAxis.table``); 0: the board knows what it has commanded."""
    control_step_ns: Fraction = Fraction(0)
    """Period of the control law; 0: it has none that is always the same."""
    clock_field: str = ""
    """Field of the frequency at its input for a clock; empty: it neither gives nor takes one (``CLOCK_OUT``,
    ``CLOCK_IN``)."""
    levels: str = ""
    """Field that has the levels of all pins, a bit each by their numbers; empty: none has."""
    analog: Mapping[str, int] = field(default_factory=dict)
    """Channels of its processor's converter, by the names of the pins."""
    means: Mapping[str, int] = field(default_factory=dict)
    """Chip's numbers of the pins that a timer can have for PWM, by the fields of their mean voltages."""
    own_fields: Mapping[str, Field] = field(default_factory=dict)
    """Fields that go by the board's own names, and not by the table's."""
    board_fields: Mapping[str, OwnField] = field(default_factory=dict)
    """Fields of the board's own among these, which its firmware writes."""
    own_faults: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """Kinds of fault that only it can have: what the core is told of each (``hil.core.abi.AxisFault``), by
    the fault's parameters."""
    make: Callable[[NativeCore, int, "AxisKind"], Any]
    """Makes the axis: ``hil.core.core_axis.CoreAxis``, or a class that is more."""
    open_outputs: frozenset[str] = frozenset()
    """Outputs that drive nothing at times: several of them may be wired to one input."""
    reads_magnet: bool = False
    """True if it reads a magnet on another axis's shaft (``CoreAxis.place_magnet``)."""
    seen_as: str = ""
    """Face by which a firmware finds it, beside that of every axis (``hil.vocab.firmware.Board``)."""

    def described(self, name: str) -> Field:
        """Field by its name here. Raises KeyError: it has none of that name."""
        return self.own_fields.get(name) or TABLE[self.fields[name]]

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
    def has_clock(self) -> bool:
        """True if it also gives and takes a clock."""
        return bool(self.clock_field)

    @property
    def has_motor(self) -> bool:
        """True if it moves a motor; if not, it is pins, or a board's own fields alone."""
        return bool(self.parameters)


def speed_limit_rpm(parameters: Mapping[str, float]) -> float:
    """Maximum speed of a shaft, whatever drags it: the native core's, by the teeth of its rotor."""
    return min(LIMIT_RPM, LIMIT_TEETH_RPM / parameters.get("rotor_teeth", 1.0))


def numbers(pins: type[IntEnum]) -> dict[str, int]:
    """Numbers of pins by name."""
    return {name: int(number) for name, number in pins.__members__.items()}
