"""Search of the home switch: towards it, to a stand, and slowly off it again; its edge is 0."""

from typing import Protocol

from hil.vocab.firmware import Axis
from hil.vocab.path import Path

SWITCH = "pin_d3"
"""Field of the input that the switch pulls low."""
SLOWLY = 0.1
"""Share of the speed of the search at which the switch is left."""


class SearchingDrive(Protocol):
    """Drive that searches its home switch."""

    axis: Axis
    acceleration_rpm_per_s: float
    is_reversed: bool
    running_rpm: float | None
    origin_deg: float

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


def is_pressed(drive: SearchingDrive) -> bool:
    """True while the switch is active, or nothing drives its input, which is low then."""
    return not drive.axis.get(SWITCH)


class HomeSearch:
    """Search at a speed whose sign is the switch's direction. ``is_over``: found or not, it has ended."""

    def __init__(self, drive: SearchingDrive, velocity_rpm: float) -> None:
        self._drive, self._velocity_rpm = drive, velocity_rpm
        self.is_over = self.has_found = False
        self._edge_deg = 0.0
        self._stand_deg: float | None = None
        """Angle at which it comes to a stand between two legs; None: it turns."""
        self._was_pressed = self._leaves = is_pressed(drive)
        """State of the switch at the last look in the leg off it, and whether this is that leg."""
        self._turn()

    def step(self) -> None:
        """Look at the switch, once in a millisecond. What else moves the drive ends the search."""
        drive = self._drive
        if self._stand_deg is not None:
            if drive.is_moving:
                self.is_over = drive.target_deg != self._stand_deg
            elif self._leaves:
                drive.origin_deg, self.has_found, self.is_over = self._edge_deg, True, True
            else:
                self._leaves, self._was_pressed, self._stand_deg = True, False, None
                self._turn()
        elif drive.running_rpm != self._rpm:
            self.is_over = True
        elif self._is_at_edge():
            self._edge_deg = drive.here_deg()
            self._stand_deg = drive.ramp_down(drive.acceleration_rpm_per_s)[-1].r

    def _is_at_edge(self) -> bool:
        """Look whether the leg has come to its end; it may have run over a narrow cam in the one before."""
        before, self._was_pressed = self._was_pressed, is_pressed(self._drive)
        return before and not self._was_pressed if self._leaves else self._was_pressed

    def _turn(self) -> None:
        drive, rpm = self._drive, -self._velocity_rpm * SLOWLY if self._leaves else self._velocity_rpm
        drive.run(-rpm if drive.is_reversed else rpm)
        self._rpm = drive.running_rpm
