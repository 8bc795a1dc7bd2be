"""Axis of a board as the drive on its interface card moves it."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from math import copysign, inf, isfinite
from struct import unpack_from
from typing import NamedTuple, Protocol

from bridges.can.canopen.cia402.motor_axis import CURRENT, MotorLook
from hil.core import CoreAxis, Snapshot
from hil.core.core_switch import CoreSwitch
from hil.core.fields import INDEX
from hil.sim.group import Group
from hil.sim.inputs import Do, Input
from hil.sim.twin import Twin
from hil.sim.verb_calls import Answer
from hil.vocab.axis import AxisState, How
from hil.vocab.path import Path
from hil.vocab.verbs import Verb, VerbRefused


class DriveSwitch(Protocol):
    """Switch of a drive."""

    def level(self, shot: Snapshot) -> int:
        """Tell whether it is active, 1 or 0, by the state of the axis."""


@dataclass(frozen=True)
class Cam:
    """Cam on the shaft, active from one angle to another, both included, in degrees."""

    from_deg: float = -inf
    to_deg: float = inf

    def level(self, shot: Snapshot) -> int:
        return int(self.from_deg <= shot.position_deg <= self.to_deg)


@dataclass(frozen=True)
class PinSwitch:
    """Switch at a pin of the board, whose level is a field of the axis."""

    field: str
    is_active_low: bool

    def level(self, shot: Snapshot) -> int:
        return int(bool(getattr(shot, self.field)) is not self.is_active_low)


@dataclass(frozen=True)
class Wayside:
    """Switch of the bench along the axis's way, with hysteresis and bounces."""

    switch: CoreSwitch

    def level(self, shot: Snapshot) -> int:
        return int(self.switch.is_active)


_VELOCITY, _TORQUE, _SHAFT = INDEX["velocity_rpm"], INDEX["torque_Nm"], INDEX["position_deg"]
_USED = ("enable", "disable", "clear_fault", "stop", "velocity", "torque", "move_abs")
_EFFORT_COUNTS = 255
"""Effort of the full current, as the verb `torque` takes it."""
_STEPS_PER_TOOTH = 4
_BOARD_FAULTS = {1: 0x8611, 2: 0x7305, 3: 0x5400}
"""Error codes of CiA 402 by a board's own codes of faults: following error, sensor 1 faulted, power section.
Source: IEC 61800-7-201:2015, table of error codes."""
_BOARD_ERROR = 0xFF00
"""Error code of another fault of the board: the first that is the manufacturer's."""


class Rating(NamedTuple):
    """Ratings of a motor, by its configuration."""

    current_A: float
    torque_Nm: float
    rotor_teeth: int


class CardMotor:
    """Axis ``part`` of a device, a ``MotorAxis`` of ``bridges.can.canopen.cia402``. ``carry_out`` lets an
    input take effect now, and raises VerbRefused. ``switches``: by name."""

    # A drive is looked at and follows a path at each SYNC: both take the shortest way.

    def __init__(
        self,
        device: Twin,
        part: str,
        group: Group,
        carry_out: Callable[[Input], Answer],
        switches: Mapping[str, DriveSwitch],
        rating: Rating,
    ) -> None:
        self._device, self._part, self._group, self._carry_out = device, part, group, carry_out
        self._axis: CoreAxis = device.axes[part]
        self._switches = switches
        self._axis.is_on_bus = True
        self._motion = self._axis.kind.motion
        kind = self._axis.kind
        self._is_servo = bool(kind.encoder_counts)
        self._commanded_rpm = INDEX.get(kind.commanded_rpm)
        self.verbs: Collection[str] = [name for name in _USED if name in device.verbs]
        self.follows_paths = device.follows_paths
        self._offset_deg = 0.0
        """Angle of a servo's encoder above the shaft's, when the loop was on last."""
        self._commanded_deg, self._direction = 0.0, 1
        """Angle of a stepper at the last look, and the direction in which it went there."""
        self.encoder_counts = kind.encoder_counts or _STEPS_PER_TOOTH * rating.rotor_teeth
        self.rated_current_A, self.rated_torque_Nm = rating.current_A, rating.torque_Nm
        self.max_velocity_rpm = self._limit("move_abs", "velocity_rpm")
        self._per_Nm = rating.current_A / rating.torque_Nm

    def _limit(self, verb: str, parameter: str) -> float:
        parameters = self._device.verbs[verb].parameters if verb in self._device.verbs else ()
        return next((each.maximum for each in parameters if each.name == parameter), inf)

    @property
    def index_deg(self) -> float | None:
        """Angle of the encoder's count 0, by the look-up table; None: a stepper has no encoder."""
        if not self._is_servo:
            return None
        angle_deg: float = unpack_from("=f", self._axis.table())[0]
        return angle_deg % 360 if isfinite(angle_deg) else 0.0

    def look(self) -> MotorLook:
        shot, device = self._axis.glance(), self._device
        state, values = self._motion(shot), shot.values
        assert state.position_deg is not None
        if not self._is_servo:
            position_deg, velocity_rpm = self._sent(state, values)
        elif state.is_on:
            position_deg, velocity_rpm = state.position_deg, values[_VELOCITY]
            self._offset_deg = position_deg - values[_SHAFT]
        else:  # its law reads the encoder only while it runs: the angle goes on with the shaft
            position_deg, velocity_rpm = values[_SHAFT] + self._offset_deg, values[_VELOCITY]
        told = device.told.get("fault_code", 0)
        return MotorLook(
            state.at_ns,
            position_deg,
            velocity_rpm,
            values[_TORQUE] * self._per_Nm,
            state.commanded_deg if state.keeps_angle or not self.follows_paths else None,
            bool(state.is_on),
            state.is_moving,
            device.power.failed,
            {name: switch.level(shot) for name, switch in self._switches.items()} if self._switches else {},
            device.is_ready,
            _BOARD_FAULTS.get(int(told), _BOARD_ERROR) if told else 0,
        )

    def _sent(self, state: AxisState, values: Sequence[float]) -> tuple[float, float]:
        """Angle and speed of a stepper, which knows where it has sent the rotor."""
        assert state.commanded_deg is not None
        if state.commanded_deg != self._commanded_deg:
            self._direction = 1 if state.commanded_deg > self._commanded_deg else -1
            self._commanded_deg = state.commanded_deg
        rpm = 0.0 if self._commanded_rpm is None else values[self._commanded_rpm]
        return state.commanded_deg, self._direction * rpm

    def measured(self, name: str) -> float:
        return self.look().current_A if name == CURRENT else float(getattr(self._axis.glance(), name))

    # ---- what moves it ----

    def enable(self) -> None:
        self._do_if("enable")

    def disable(self) -> None:
        self._do_if("disable")

    def clear_fault(self) -> None:
        self._do_if("clear_fault")

    def follow(self, path: Path, start_ns: int = 0) -> None:
        # As an input, but for the board's main program, which has nothing to do with it.
        self._device.follow(path, start_ns, self._group.now_ns, self._part)
        self._group.note_due(self._device)

    def velocity(self, rpm: float) -> None:
        self._do("velocity", velocity_rpm=rpm)

    def torque(self, current_A: float) -> None:
        self._do("torque", effort_count=current_A / self.rated_current_A * _EFFORT_COUNTS)

    def move_abs(self, position_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float) -> None:
        self._do(
            "move_abs",
            position_deg=position_deg,
            velocity_rpm=velocity_rpm,
            acceleration_rpm_per_s=acceleration_rpm_per_s,
        )

    def stop(self, how: How, acceleration_rpm_per_s: float) -> None:
        self._do("stop", how=how, acceleration_rpm_per_s=acceleration_rpm_per_s)

    def _do_if(self, name: str) -> None:
        if name in self._device.verbs:
            self._do(name)

    def _do(self, name: str, **wanted: float | str) -> None:
        verb = self._device.verbs.get(name)
        if verb is None:
            raise VerbRefused("no_verb", f"a {self._device.profile} has no verb {name}")
        self._carry_out(Do(name, tuple(verb.filled(_given(verb, wanted)).items())))


def _given(verb: Verb, wanted: Mapping[str, float | str]) -> dict[str, float | str]:
    """Parameters that a verb has, of what is wanted; whole where it takes only whole ones, and not 0 where
    that is less than it takes."""
    given: dict[str, float | str] = {}
    for parameter in verb.parameters:
        value = wanted.get(parameter.name)
        if value is None:
            continue
        if parameter.is_whole and not isinstance(value, str):
            value = copysign(max(round(abs(value)), parameter.minimum), value)
        given[parameter.name] = value
    return given
