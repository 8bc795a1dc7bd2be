"""Axis of a board as the module on its interface card moves it, in degrees and rpm."""

from collections.abc import Callable, Mapping
from math import copysign
from typing import NamedTuple

from hil.core import CoreAxis
from hil.core.fields import INDEX
from hil.firmware.set_point_paths import at, joined
from hil.sim.inputs import Do, Follow, Input
from hil.sim.motion_end import BegunMotion, begun_motion
from hil.sim.twin import Twin
from hil.sim.verb_calls import Answer
from hil.vocab.path import DEG_PER_S, Path, PathPiece
from hil.vocab.time import Clock
from hil.vocab.verbs import Verb, VerbRefused

_VELOCITY, _SHAFT = INDEX["velocity_rpm"], INDEX["position_deg"]
_ROTATES_S = 86_400.0
"""Time after which a rotation ends that nobody ends."""


class AxisLook(NamedTuple):
    """Axis now: ``position_deg`` is what its board knows of it."""

    position_deg: float
    velocity_rpm: float


class ModuleAxis:
    """Axis ``part`` of a device. ``carry_out`` lets an input take effect now, and raises VerbRefused."""

    def __init__(self, device: Twin, part: str, clock: Clock, carry_out: Callable[[Input], Answer]) -> None:
        self.device = device
        self._part, self._clock, self._carry_out = part, clock, carry_out
        self._axis: CoreAxis = device.axes[part]
        self._kind = self._axis.kind
        self._commanded_rpm = INDEX.get(self._kind.commanded_rpm)
        self._offset_deg = 0.0
        """Angle of a servo's encoder above the shaft's, when the loop was on last."""
        self._last_deg, self._sign = 0.0, 1
        """Angle of a stepper at the last look, and the direction in which it went there."""
        self._rotation: tuple[Path, int] | None = None
        """Path of a rotation, and its beginning."""
        self._motion: BegunMotion | None = None
        """Move to an angle that was begun last, unless something else was begun since."""
        self.inputs = [pin for pin in self._kind.inputs if self._kind.level_field(pin)]

    def look(self) -> AxisLook:
        shot = self._axis.snapshot()
        state, values = self._kind.motion(shot), shot.values
        if self._kind.encoder_counts:
            if state.is_on and state.position_deg is not None:
                self._offset_deg = state.position_deg - values[_SHAFT]
            return AxisLook(values[_SHAFT] + self._offset_deg, values[_VELOCITY])
        if state.commanded_deg is None:
            return AxisLook(values[_SHAFT], values[_VELOCITY])
        if state.commanded_deg != self._last_deg:
            self._sign = 1 if state.commanded_deg > self._last_deg else -1
            self._last_deg = state.commanded_deg
        rpm = values[_VELOCITY] if self._commanded_rpm is None else self._sign * values[self._commanded_rpm]
        return AxisLook(state.commanded_deg, rpm)

    @property
    def has_arrived(self) -> bool:
        """True if the last thing that it did was a move to an angle, and that is over."""
        if self._motion is None:
            return False
        state = self._kind.motion(self._axis.snapshot())
        return self._motion.was_cut_short(self.device, self._axis, state, self._clock.now_ns) is False

    def level(self, pin: str) -> int:
        """Level of an input, 0 or 1."""
        name = self._kind.level_field(pin)
        return int(self._axis.snapshot().values[INDEX[name]]) if name else 0

    # ---- what moves it; each raises VerbRefused ----

    def move(self, position_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float) -> None:
        """Go to an angle."""
        self._enable()
        self._rotation = None
        answer = self._do(
            "move_abs",
            position_deg=position_deg,
            velocity_rpm=velocity_rpm,
            acceleration_rpm_per_s=acceleration_rpm_per_s,
        )
        self._motion = begun_motion(self._clock.now_ns, answer)

    def rotate(self, rpm: float, acceleration_rpm_per_s: float) -> None:
        """Turn at a speed, with a ramp if the board's set-point follows paths."""
        self._enable()
        if not self.device.follows_paths:
            self._do("velocity", velocity_rpm=rpm)
            self._motion = self._rotation = None
            return
        from_deg, rate = self._set_point()
        change = rpm * DEG_PER_S - rate
        ramp_per_s2 = copysign(acceleration_rpm_per_s * DEG_PER_S, change)
        path = joined(from_deg, rate, [(change / ramp_per_s2, ramp_per_s2), (_ROTATES_S, 0.0)])
        path = (*path[:-1], PathPiece(0, path[-1].r))
        self._carry_out(Follow(0, path))
        self._motion, self._rotation = None, (path, self._clock.now_ns)

    def stop(self, acceleration_rpm_per_s: float) -> None:
        """End all motion, with a ramp."""
        self._motion = self._rotation = None
        self._do("stop", how="grace", acceleration_rpm_per_s=acceleration_rpm_per_s)

    def _set_point(self) -> tuple[float, float]:
        """Set-point in degrees, and its rate in degrees a second."""
        if self._rotation:
            return at(self._rotation[0], self._clock.now_ns - self._rotation[1])
        state = self._kind.motion(self._axis.snapshot())
        look = self.look()
        if state.keeps_angle and state.commanded_deg is not None:
            return state.commanded_deg, look.velocity_rpm * DEG_PER_S if state.is_moving else 0.0
        return look.position_deg, look.velocity_rpm * DEG_PER_S

    def _enable(self) -> None:
        """Switch the loop on, as a module does with the first motion."""
        state = self._kind.motion(self._axis.snapshot())
        if state.is_on is False and "enable" in self.device.verbs:
            self._do("enable")

    def _do(self, name: str, **wanted: float | str) -> Answer:
        verb = self.device.verbs.get(name)
        if verb is None:
            raise VerbRefused("no_verb", f"a {self.device.profile} has no verb {name}")
        return self._carry_out(Do(name, tuple(verb.filled(_given(verb, wanted)).items())))


def _given(verb: Verb, wanted: Mapping[str, float | str]) -> dict[str, float | str]:
    """Parameters that a verb has, of what is wanted; whole where it takes only whole ones."""
    given: dict[str, float | str] = {}
    for parameter in verb.parameters:
        value = wanted.get(parameter.name)
        if value is not None:
            is_rounded = parameter.is_whole and not isinstance(value, str)
            given[parameter.name] = round(float(value)) if is_rounded else value
    return given
