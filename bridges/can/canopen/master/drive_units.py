"""Units of a drive: what its numbers of position, speed, acceleration and current are.

Source: CiA 402-2, 6.7 factor group: 608Fh position encoder resolution, 6091h gear ratio, 6092h feed constant,
60A8h to 60AAh SI units; the bytes of these are prefix, numerator, denominator (CiA 303-2).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

Objects = Mapping[tuple[int, int], int]
"""Values of objects, those that the drive has, by index and sub-index."""

FACTOR_OBJECTS = (
    *((0x6092, 1), (0x6092, 2), (0x608F, 1), (0x608F, 2), (0x6091, 1), (0x6091, 2)),
    *((0x60A8, 0), (0x60A9, 0), (0x60AA, 0), (0x6075, 0)),
)
"""Objects that the units are made of; no drive has all of them."""
_DEG = {0xB4: 360.0, 0x41: 1.0, 0x10: 57.29577951308232}
"""Degrees of the numerators that are angles: turns, degrees, radians."""
_S = {0x03: 1.0, 0x47: 60.0}
"""Seconds of the denominators that are times: seconds, minutes."""
_PER_S2 = 0x57
_RPM_DEG_PER_S = 6.0


@dataclass(frozen=True)
class GivenUnits:
    """Units that a configuration gives; None: as the drive says. Numbers of the drive's units."""

    position_per_turn: float | None = None
    velocity_per_rpm: float | None = None
    acceleration_per_rpm_per_s: float | None = None


NO_UNITS = GivenUnits()
"""Units of a drive of which a configuration says none."""


@dataclass(frozen=True)
class DriveUnits:
    """Units of one drive, all above 0. ``current_A``: of a thousandth of the rated current; None: unknown."""

    position_per_deg: float
    velocity_per_rpm: float
    acceleration_per_rpm_per_s: float
    current_A: float | None = None

    def position(self, position_deg: float) -> int:
        """Position in the drive's units. Raises ValueError: its 32 bits cannot hold it."""
        units = round(position_deg * self.position_per_deg)
        if not -(2**31) <= units < 2**31:
            raise ValueError(f"the drive cannot hold {position_deg:g} deg: it would be {units} of its units")
        return units

    def velocity(self, velocity_rpm: float) -> int:
        """Speed in the drive's units, at least one of them."""
        return _held(velocity_rpm * self.velocity_per_rpm, "rpm", velocity_rpm)

    def acceleration(self, acceleration_rpm_per_s: float) -> int:
        """Acceleration in the drive's units, at least one of them."""
        return _held(
            acceleration_rpm_per_s * self.acceleration_per_rpm_per_s, "rpm/s", acceleration_rpm_per_s
        )


def _held(units: float, unit: str, value: float) -> int:
    if not units < 2**32:
        raise ValueError(f"the drive cannot hold {value:g} {unit}")
    return max(round(units), 1)


class UnitsUnknown(Exception):
    """Drive that does not say what a turn is."""


def units_of(objects: Objects, given: GivenUnits) -> DriveUnits:
    """Units of a drive by its objects; what is given holds.

    A speed is in position units a second, an acceleration in speed units a second, unless SI units say
    otherwise.

    Raises:
        UnitsUnknown: neither the drive nor the configuration says how many units a turn has.
    """
    per_deg = (given.position_per_turn or _per_turn(objects)) / 360.0
    # Degrees of the drive's units: of position, of speed in a second, of acceleration in a second squared.
    per_s_deg = si_deg(objects, 0x60A9) or 1 / per_deg
    per_s2_deg = si_deg(objects, 0x60AA) or per_s_deg
    units = DriveUnits(per_deg, _RPM_DEG_PER_S / per_s_deg, _RPM_DEG_PER_S / per_s2_deg)
    rated_mA = objects.get((0x6075, 0), 0)
    return replace(
        units,
        velocity_per_rpm=given.velocity_per_rpm or units.velocity_per_rpm,
        acceleration_per_rpm_per_s=given.acceleration_per_rpm_per_s
        or (given.velocity_per_rpm or units.acceleration_per_rpm_per_s),
        current_A=rated_mA / 1e6 if rated_mA else None,
    )


def _per_turn(objects: Objects) -> float:
    """Position units of a turn of the shaft that the load is on."""
    if unit_deg := si_deg(objects, 0x60A8):
        return 360.0 / unit_deg
    feed = _ratio(objects, 0x6092)
    if feed is not None and feed > 1:  # a drive that has no use for it says 1
        return feed
    if (counts := _ratio(objects, 0x608F)) is not None and counts > 1:
        return counts * (_ratio(objects, 0x6091) or 1.0)
    raise UnitsUnknown("it does not say how many units a turn has (6092h, 608Fh, 60A8h)")


def _ratio(objects: Objects, index: int) -> float | None:
    top, bottom = objects.get((index, 1), 0), objects.get((index, 2), 1)
    return top / bottom if top > 0 and bottom > 0 else None


def si_deg(objects: Objects, index: int) -> float | None:
    """Degrees of an SI unit, for speeds in a second, for accelerations in a second squared; None: it is no
    angle, or is not said."""
    word = objects.get((index, 0), 0) & 0xFFFF_FFFF
    exponent, top, below = (word >> 24) - (word >> 31 << 8), word >> 16 & 0xFF, word >> 8 & 0xFF
    angle_deg = _DEG.get(top, 0.0) * 10.0**exponent
    if index == 0x60A8:
        return angle_deg if below == 0 and angle_deg else None
    if index == 0x60A9:
        return angle_deg / _S[below] if below in _S and angle_deg else None
    if below == _PER_S2:
        return angle_deg or None
    seconds = _S.get(below), _S.get(word & 0xFF)
    return angle_deg / (seconds[0] * seconds[1]) if seconds[0] and seconds[1] and angle_deg else None
