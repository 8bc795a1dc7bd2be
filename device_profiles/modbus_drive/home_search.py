"""Search for home by the drive's inputs: legs of the homing method, each to a stand; home is 0 then."""

from collections.abc import Mapping
from typing import NamedTuple, Protocol

from hil.firmware.homing_methods import HOME, NEGATIVE, POSITIVE, HomingEnd, HomingMethod, HomingSearch
from hil.vocab.firmware import Axis
from hil.vocab.path import Path

SWITCH, LOWER, UPPER = "pin_d3", "pin_dir", "pin_step"
"""Fields of the inputs D3, D0 and D1: the home switch pulls its own low; a limit switch is normally closed to
ground, so that its own is high where the switch or its wire is open. Inputs that nothing drives are low."""
INDEX_DEG = 0.0
"""Angle within a turn of the encoder's index: its count 0."""


class SearchingDrive(Protocol):
    """Drive that searches home."""

    axis: Axis
    acceleration_rpm_per_s: float
    is_reversed: bool
    running_rpm: float | None

    @property
    def is_moving(self) -> bool:
        """True while a path is under way."""

    @property
    def target_deg(self) -> float:
        """Angle at which it ends."""

    def here_deg(self) -> float:
        """Angle of the shaft now."""

    def run(self, velocity_rpm: float | None = None) -> None:
        """Turn at a speed until a stop."""

    def ramp_down(self, acceleration_rpm_per_s: float) -> Path:
        """Stop on a ramp."""


class InputsLook(NamedTuple):
    """Look at the drive's shaft and inputs, a ``HomingLook``."""

    position_deg: float
    inputs: Mapping[str, int]


def is_at_limit(axis: Axis, direction: float) -> bool:
    """True if the limit switch in a direction, by its sign, is active."""
    return bool(direction and axis.get(UPPER if direction > 0 else LOWER))


class HomeSearch:
    """Search that has begun. ``is_over``: found or not, it has ended; ``home_deg``: home, once found."""

    def __init__(self, drive: SearchingDrive, method: HomingMethod, fast_rpm: float, slow_rpm: float) -> None:
        self._drive, self._fast_rpm, self._slow_rpm = drive, fast_rpm, slow_rpm
        self.is_over = False
        self._search = HomingSearch(method, self._look(), INDEX_DEG)
        self._ended: HomingEnd | None = None
        self._stand_deg = 0.0
        """End of a leg, and the angle at which it comes to a stand behind it; None: it turns."""
        self._turn()

    @property
    def home_deg(self) -> float | None:
        return self._search.home_deg

    def step(self) -> None:
        """Look at the inputs, once in a millisecond. What else moves the drive ends the search."""
        drive = self._drive
        if self.is_over:
            return
        if self._ended:
            if drive.is_moving:
                self.is_over = drive.target_deg != self._stand_deg
                return
            ended, self._ended = self._ended, None
            self._search.go_on(ended, self._look())
            self._turn()
        elif drive.running_rpm != self._rpm:
            self.is_over = True
        elif end := self._search.end_of_leg(self._look()):
            self._ended = end
            self._stand_deg = drive.ramp_down(drive.acceleration_rpm_per_s)[-1].r

    def _look(self) -> InputsLook:
        axis = self._drive.axis
        levels = {HOME: not axis.get(SWITCH), NEGATIVE: axis.get(LOWER), POSITIVE: axis.get(UPPER)}
        return InputsLook(self._drive.here_deg(), {name: int(level) for name, level in levels.items()})

    def _turn(self) -> None:
        """Begin the leg, or end the search."""
        drive, leg = self._drive, self._search.leg
        if leg is None:
            self.is_over = True
            return
        rpm = leg.direction * (self._fast_rpm if leg.is_fast else self._slow_rpm)
        drive.run(-rpm if drive.is_reversed else rpm)
        self._rpm = drive.running_rpm
