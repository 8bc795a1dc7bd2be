"""Units of a drive's user: degrees of the motor from what its objects count, and back.

A user position is ``6092h:1 / 6092h:2 / (6091h:1 / 6091h:2)`` units a turn of the motor, by default 360,000:
thousandths of a degree. A velocity is ``6096h:1 / 6096h:2`` times user positions a second, an acceleration
``6097h:1 / 6097h:2`` times user positions a second squared.
"""

from collections.abc import Callable
from dataclasses import dataclass

FACTORS = (0x6091, 0x6092, 0x6096, 0x6097, 0x607E)
"""Objects that a ``UserUnits`` is made of."""
_POSITION_IS_REVERSED, _VELOCITY_IS_REVERSED = 0x80, 0x40
INT32 = 2**31 - 1


def to_int32(value: float) -> int:
    """Round to a whole number that an INTEGER32 can have: of those that are beyond it the nearest."""
    return max(-INT32 - 1, min(INT32, round(value)))


@dataclass(frozen=True)
class UserUnits:
    """Conversions. ``deg`` and ``per_deg`` are whole numbers, so that each is rounded once: a unit has
    ``deg / per_deg`` degrees, with the sign of the polarity. ``zero_deg``: the angle of user position 0."""

    deg: int
    per_deg: int
    deg_per_s: float
    """Degrees a second of a unit of velocity, with its polarity's sign."""
    deg_per_s2: float
    """Degrees a second squared of a unit of acceleration."""
    zero_deg: float = 0.0

    @classmethod
    def made(cls, value: Callable[[int, int], int], zero_deg: float) -> "UserUnits":
        """Make the conversions of objects' values."""
        gear, shafts = value(0x6091, 1), value(0x6091, 2)
        feed, turns = value(0x6092, 1), value(0x6092, 2)
        deg, per_deg = 360 * gear * turns, shafts * feed
        polarity = value(0x607E, 0)
        sign = -1 if polarity & _VELOCITY_IS_REVERSED else 1
        return cls(
            -deg if polarity & _POSITION_IS_REVERSED else deg,
            per_deg,
            sign * deg * value(0x6096, 2) / (per_deg * value(0x6096, 1)),
            deg * value(0x6097, 2) / (per_deg * value(0x6097, 1)),
            zero_deg,
        )

    def angle_deg(self, position: int) -> float:
        """Angle of the motor at a user position."""
        return self.zero_deg + position * self.deg / self.per_deg

    def distance_deg(self, distance: int) -> float:
        """Angle between two user positions."""
        return distance * self.deg / self.per_deg

    def position(self, angle_deg: float) -> int:
        """User position at an angle of the motor."""
        return to_int32((angle_deg - self.zero_deg) * self.per_deg / self.deg)

    def distance(self, angle_deg: float) -> int:
        """Angle in user units, with its sign."""
        return to_int32(angle_deg * self.per_deg / self.deg)

    def velocity(self, deg_per_s: float) -> int:
        """Speed in user units."""
        return to_int32(deg_per_s / self.deg_per_s)
