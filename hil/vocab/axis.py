"""Axis as runs and doors see it: one contract, kept by twins and by real boards.

``AxisNow`` is what a plan needs to know before anything moves, ``AxisState`` what an axis says of itself at
one time, ``Axis`` what a run does with it. Each kind of axis says its state in these words, whatever its own
fields are called.
"""

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Literal, NamedTuple, Protocol

from hil.vocab.late_dataclass import dataclass
from hil.vocab.parameters import Parameter
from hil.vocab.path import Path
from hil.vocab.time import SimTimeNs

How = Literal["grace", "prejudice"]
"""Ways to stop: a controlled stop, with a ramp, or an immediate one."""

CONTROL_MODES = {"position": "x", "velocity": "v", "torque": "t", "hybrid": "h"}
"""Modes of a servo's control law, each with the letter that its field `mode` has."""

TURNS_RPM = 5.0
"""Speed below which a shaft stands whose drive or set-point does not say it: above the noise of a measured
speed."""

NOT_JOINED = "a real board's path stays as it is once it was given"

Sample = tuple[float, ...]
"""Time in nanoseconds, set-point and position in degrees."""


@dataclass(frozen=True)
class AxisNow:
    """Axis before a run. ``why_not``: the reason why it cannot take part, or None; ``remedy``: what helps."""

    position_deg: float
    """Angle from which its motion is planned: its set-point where it has one."""
    follows_paths: bool
    """True if the set-point follows paths; if not, the axis makes ramps of its own to the angles it is sent
    to."""
    fields: Sequence[str] = ()
    """Names of fields that a run may wait for."""
    pins: Sequence[str] = ()
    """Names of inputs that a run may drive."""
    why_not: str | None = None
    remedy: str = "leave it out"
    tells_position: bool = True
    """True if the axis tells where it is while it moves; if not, the end of its motion is awaited."""
    bounds: Mapping[str, Parameter] = field(default_factory=dict)
    """Bounds of what a run asks of the board, by names of verbs' parameters."""
    is_awaited: bool = False
    """True if the end of its motion is awaited all the same: it comes later than planned, over a line."""

    @property
    def joins_paths(self) -> bool:
        """True if it takes another path while it follows one (``Axis.join``)."""
        return self.follows_paths and self.tells_position and not self.is_awaited


class AxisState(NamedTuple):
    """State of an axis at one time. None: it does not tell."""

    at_ns: SimTimeNs
    commanded_deg: float | None
    """Set-point, in degrees if it is an angle; of a real board, the last that it confirmed."""
    position_deg: float | None
    is_moving: bool
    """True while the axis moves by what it was given, a motion without an end included."""
    is_under_way: bool
    """True until a motion with an end that the axis was given has ended, also before it begins."""
    is_on: bool | None = None
    """True if the axis would move if it were told to: its control loop, if it has one, is on."""
    keeps_angle: bool = False
    """True if a loop keeps the shaft at the set-point, an angle."""

    @property
    def off_by_deg(self) -> float:
        """Distance of the shaft from the angle that a loop keeps it at; 0: none does, or it does not tell."""
        if not self.keeps_angle or self.commanded_deg is None or self.position_deg is None:
            return 0.0
        return abs(self.commanded_deg - self.position_deg)


class Axis(Protocol):
    """Axis of one board. A run holds it from its beginning to its end, and only then gives it motions.

    Motions raise ``VerbRefused`` when the board does not take them. A motion for later can be refused when
    its time has come: ``refusal`` says so.
    """

    @property
    def lead_ns(self) -> int:
        """Least time between the giving of a motion and its start."""

    @property
    def failure(self) -> str | None:
        """Reason why the axis does nothing any more, or None."""

    @property
    def refusal(self) -> str | None:
        """Reason why the axis did not do what it was given for later since ``hold``, or None."""

    def state(self) -> AxisState:
        """State of the axis now."""

    def field(self, name: str) -> float:
        """Value of a field (``AxisNow.fields``) now, for a run that waits for it."""

    def samples(self) -> Sequence[Sample]:
        """Samples since ``hold`` or the last call, 1 ms apart; none of an axis that tells no position."""

    def hold(self) -> None:
        """Begin a run with it: it is sampled, and where others wait for their turn at the board, they do."""

    def release(self) -> None:
        """End what ``hold`` began; a board that still moves is let go when it stands."""

    def follow(self, path: Path, start_ns: int) -> int:
        """Let the axis's set-point go along a path from a time on; answers that time, or the time at which
        it begins as the axis was given it late. An axis that ``follows_paths``."""

    def join(self, path: Path, start_ns: int) -> None:
        """Let the axis's set-point go on along a path that began at a time, from where that path is now; an
        axis that ``joins_paths``."""

    def move(self, position_deg: float, velocity_rpm: float, start_ns: int) -> None:
        """Send the axis to an angle from a time on, by ramps of its own; an axis that follows no paths."""

    def stop(self, how: How, acceleration_rpm_per_s: float) -> None:
        """Stop the axis, whatever it does. ``acceleration_rpm_per_s``: of a ramp that is not the board's
        own."""

    def set_pin(self, pin: str, level: int, at_ns: int) -> None:
        """Drive one of its inputs at a time."""


class Axes(Protocol):
    """Axes of a bench, by their devices' names, and its time."""

    @property
    def now_ns(self) -> int: ...

    def axes(self) -> dict[str, AxisNow]:
        """State of every axis, as a plan begins with it."""

    def __getitem__(self, device: str) -> Axis:
        """The axis of a device that can take part in runs; each run asks for its own."""
