"""Switches of a drive: cams on its shaft, or pins of its board."""

from dataclasses import dataclass
from math import inf
from typing import Protocol

from hil.core import Snapshot


class Switch(Protocol):
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
