"""Shared state of a drive's modes: its axis, the values of its objects, units, limits, and the set-point.

A user position is ``6092h:1 / 6092h:2 / (6091h:1 / 6091h:2)`` units a turn of the motor, by default 360,000:
thousandths of a degree. A velocity is ``6096h:1 / 6096h:2`` times user positions a second, an acceleration
``6097h:1 / 6097h:2`` times user positions a second squared.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from types import MappingProxyType
from typing import Any, NamedTuple

from bridges.can.canopen.cia402.motor_axis import MotorAxis, MotorLook
from bridges.can.canopen.cia402.movers import MotionRules, Mover, PathMover, RampMover
from bridges.can.canopen.cia402.objects import LIMITED_JERK
from bridges.can.canopen.node.application import Entry
from bridges.can.canopen.node.canopen_node import CanOpenNode
from hil.firmware.homing_methods import NEGATIVE, POSITIVE
from hil.vocab.path import DEG_PER_S
from hil.vocab.time import NS_PER_MS, NS_PER_S

FACTORS = (0x6091, 0x6092, 0x6096, 0x6097, 0x607E)
"""Objects that a ``UserUnits`` is made of."""
_POSITION_IS_REVERSED, _VELOCITY_IS_REVERSED = 0x80, 0x40
INT32 = 2**31 - 1


def to_int32(value: float) -> int:
    """Round to a whole number that an INTEGER32 can have: of those that are beyond it the nearest."""
    whole = round(value)
    return whole if abs(whole) <= INT32 else INT32 if whole > 0 else -INT32 - 1


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


class MakersWays(NamedTuple):
    """Ways of a maker's drive that are not in its objects. ``factors``: values of factor objects that it has
    none of, or that its file does not give."""

    factors: Mapping[tuple[int, int], int] = MappingProxyType({})
    zero_is_off: bool = False
    """True if a window of 0 and limits of 0 and 0 are none."""


OWN_WAYS = MakersWays()
"""Ways of hil's own drive."""
ANY = 2**32 - 1
"""Window that everything is in."""
_CONVERTED = frozenset((*FACTORS, 0x607D, 0x6080, 0x60C2, 0x6065, 0x6066))


def _period_ns(count: int, power: int) -> int:
    """Time of 60C2h, at least a millisecond where a maker's file has none that can be."""
    if not (count > 0 and -9 <= power <= 0):
        return NS_PER_MS
    return NS_PER_S * count // int(10**-power)


class DriveContext:
    """Axis, values and units of one drive, from a power-up of its card on."""

    def __init__(
        self,
        axis: MotorAxis,
        services: CanOpenNode,
        entries: Sequence[Entry],
        ways: MakersWays = OWN_WAYS,
    ) -> None:
        self.axis, self.services = axis, services
        self._ways = ways
        self._defaults = {(entry.index, entry.subindex): entry.default for entry in entries}
        self._node_value: Callable[[int, int], Any] = self._default
        self.mover: Mover = PathMover(axis) if axis.follows_paths else RampMover(axis)
        self._has_limits = not {NEGATIVE, POSITIVE}.isdisjoint(axis.look().inputs)
        self.is_limited = False
        """True while what was asked for is beyond a limit: bit 11."""
        self.torque_demand = 0.0
        """Torque that mode 4 asks for, in thousandths."""
        self._seen: MotorLook | None = None
        self.period_ns = 0
        """Time from SYNC to SYNC."""
        self.following_deg, self.following_ns = inf, 0
        """Greatest distance from the set-point, and time for which it may be exceeded."""
        self._home_deg = self._zero_deg = 0.0
        self._convert()

    def value(self, index: int, subindex: int = 0) -> int:
        """Value of an object, as the node has it: of what one PDO writes all is there at once."""
        value: int = self._node_value(index, subindex)
        return value

    def steps(self, index: int, subindex: int = 0) -> int:
        """Value of an object of rates or ramps, at least 1: that of a maker's file may be 0."""
        return max(self.value(index, subindex), 1)

    def most(self, index: int) -> float:
        """Value of an object that bounds others; 0 in a maker's file is no bound."""
        return self.value(index) or inf

    def note(self, index: int) -> None:
        """Take note of an object that was written."""
        if index in _CONVERTED:
            self._convert()

    def load(self) -> None:
        """Take the values of the node, which has them now."""
        self._node_value = self.services.value
        self._convert()

    def look(self, now_ns: int) -> MotorLook:
        """Look at the axis; once at a time, unless ``forget`` was called."""
        if self._seen is None or self._seen.at_ns != now_ns:
            self._seen = self.axis.look()
        return self._seen

    def forget(self) -> None:
        """Look again next time: the axis was told something."""
        self._seen = None

    def take_home(self, home_deg: float) -> None:
        """Let an angle be the home position."""
        self._home_deg = home_deg
        self._zero_deg = home_deg + self.units.distance_deg(self.value(0x607C))
        self._convert()

    def rules(self, speed: float | None = None) -> MotionRules:
        """Rules of a profile's motion: by the objects, or at another speed, deg/s."""
        units = self.units
        if speed is None:
            speed = self.steps(0x6081) * abs(units.deg_per_s)
        speed = min(speed, self.most(0x607F) * abs(units.deg_per_s), self.max_speed)
        up = min(self.steps(0x6083), self.most(0x60C5)) * units.deg_per_s2
        down = min(self.steps(0x6084), self.most(0x60C6)) * units.deg_per_s2
        is_smooth = self.axis.follows_paths and self.value(0x6086) == LIMITED_JERK
        return MotionRules(speed, up, down, self.steps(0x60A4, 1) * units.deg_per_s2 if is_smooth else None)

    def ramp(self, *, is_quick: bool) -> float:
        """Deceleration of a stop, deg/s2: the profile's, or that of a quick stop."""
        steps = min(self.steps(0x6085 if is_quick else 0x6084), self.most(0x60C6))
        return steps * self.units.deg_per_s2

    def within(self, angle_deg: float) -> float:
        """Angle within the software limits that is nearest; notes whether that is another one."""
        low_deg, high_deg = self.bounds_deg
        self.is_limited = not low_deg <= angle_deg <= high_deg
        return min(max(angle_deg, low_deg), high_deg) if self.is_limited else angle_deg

    def bound_ahead_deg(self, rate: float) -> float | None:
        """Software limit ahead of a motion; None: there is none."""
        bound_deg = self.bounds_deg[rate > 0]
        return bound_deg if abs(bound_deg) != inf else None

    def is_blocked(self, direction: float, now_ns: int) -> bool:
        """True if the limit switch on that side of the motor is active; ``direction`` is 0 of no motion."""
        if not direction or not self._has_limits:
            return False
        return bool(self.look(now_ns).inputs.get(POSITIVE if direction > 0 else NEGATIVE))

    def following_error_deg(self, now_ns: int) -> float:
        """Set-point minus position: both the board's own, of one moment."""
        return self.off_deg(self.look(now_ns), now_ns)

    def off_deg(self, look: MotorLook, now_ns: int) -> float:
        """Set-point minus position at a look of now."""
        if look.commanded_deg is None:
            return self.mover.where(now_ns).deg - look.position_deg
        return look.commanded_deg - look.position_deg

    def window_deg(self, index: int) -> float:
        """Position window of an object in degrees."""
        units = self.value(index)
        is_none = units == ANY or (units == 0 and self._ways.zero_is_off)
        return inf if is_none else abs(self.units.distance_deg(units))

    def ms(self, index: int) -> int:
        """Time of an object, in nanoseconds."""
        return self.value(index) * NS_PER_MS

    def _default(self, index: int, subindex: int) -> Any:
        return self._defaults[index, subindex]

    def _factor(self, index: int, subindex: int) -> int:
        found = self._ways.factors.get((index, subindex))
        return self.value(index, subindex) if found is None else found

    def _convert(self) -> None:
        """Work out what stands in the values, for each SYNC."""
        self.units = UserUnits.made(self._factor if self._ways.factors else self.value, self._zero_deg)
        if self.axis.follows_paths:
            self.period_ns = _period_ns(self.value(0x60C2, 1), self.value(0x60C2, 2))
        self.following_deg, self.following_ns = self.window_deg(0x6065), self.ms(0x6066)
        self.max_speed = min(self.most(0x6080), self.axis.max_velocity_rpm) * DEG_PER_S
        home = replace(self.units, zero_deg=self._home_deg)
        low, high = self.value(0x607D, 1), self.value(0x607D, 2)
        if self._ways.zero_is_off and low == high == 0:
            low, high = -INT32 - 1, INT32
        at_low = -inf if low == -INT32 - 1 else home.angle_deg(low)
        at_high = inf if high == INT32 else home.angle_deg(high)
        if self.units.deg < 0:
            at_low, at_high = -at_high if high == INT32 else at_high, -at_low if low == -INT32 - 1 else at_low
        self.bounds_deg = at_low, at_high
