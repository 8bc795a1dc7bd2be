"""Axis of a board as a drive's profile sees it: one contract, whatever the board's own verbs are."""

from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import NamedTuple, Protocol

from hil.vocab.axis import How
from hil.vocab.path import Path

CURRENT = "current_A"
"""Name by which ``MotorAxis.measured`` answers the current that makes torque."""
_NO_INPUTS: Mapping[str, int] = MappingProxyType({})


class MotorLook(NamedTuple):
    """Axis at one simulated time. Made for each SYNC: cheap things only."""

    at_ns: int
    position_deg: float
    """Angle of the shaft with turns, as the board knows it: by its encoder, if it has one."""
    velocity_rpm: float
    current_A: float
    """Current that makes torque; it has the torque's sign."""
    commanded_deg: float | None
    """Set-point, if it is an angle."""
    is_on: bool
    """True if the board would move the shaft if it were told to; always of a board without a loop."""
    is_moving: bool
    """True while what the axis was given is under way."""
    failure: str | None = None
    """Reason why the board does nothing any more: the drive is gone with it."""
    inputs: Mapping[str, int] = _NO_INPUTS
    """Levels of switches and other inputs by name, 1 active: always the same names, of those in
    ``hil.firmware.homing_methods`` those that there are."""
    is_ready: bool = True
    """False while the board starts or is in a routine of its own, and takes no verbs."""
    fault_code: int = 0
    """Error code by CiA 402 of a fault that the board itself reports; 0: none."""


class MotorAxis(Protocol):
    """Axis that a drive moves. All calls act at the present simulated time; those that move the axis raise
    ``VerbRefused``. Numbers that the board's verb takes only whole are rounded, those that it does not take
    at all are left out."""

    @property
    def verbs(self) -> Collection[str]:
        """Those of enable, disable, clear_fault, stop, velocity, torque and move_abs that the board has."""

    @property
    def follows_paths(self) -> bool:
        """True if the set-point follows paths; if not, the axis makes ramps of its own."""

    @property
    def index_deg(self) -> float | None:
        """Angle within a turn, 0 to 360, at which the encoder has its index pulse; None: no encoder."""

    @property
    def encoder_counts(self) -> int:
        """Counts of the encoder in a turn, or pulses of a stepper."""

    @property
    def rated_current_A(self) -> float:
        """Current that 6071h to 6078h count in thousandths; ``torque`` is given no more than this."""

    @property
    def rated_torque_Nm(self) -> float:
        """Torque at that current."""

    @property
    def max_velocity_rpm(self) -> float:
        """Greatest speed that its verbs take."""

    def look(self) -> MotorLook:
        """Look at the axis now."""

    def measured(self, name: str) -> float:
        """Look at one field of the axis, which it has, or at ``CURRENT``."""

    def enable(self) -> None:
        """Switch the loop on, which holds the shaft where it is; nothing of a board without a loop."""

    def disable(self) -> None:
        """Take the current off; nothing of a board without a loop."""

    def clear_fault(self) -> None:
        """Clear a fault of the board; nothing if there is no such verb."""

    def follow(self, path: Path, start_ns: int = 0) -> None:
        """Let the set-point follow a path in degrees, from a time or from now on: as for a run."""

    def velocity(self, rpm: float) -> None:
        """Turn at a speed, by the board's own ramps; for boards that follow no paths."""

    def torque(self, current_A: float) -> None:
        """Make the torque of a current, with its sign."""

    def move_abs(self, position_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float) -> None:
        """Go to an angle by the board's own ramps; for boards that follow no paths."""

    def stop(self, how: How, acceleration_rpm_per_s: float) -> None:
        """Stop: ``grace`` with a ramp (controlled), ``prejudice`` at once (immediate)."""
