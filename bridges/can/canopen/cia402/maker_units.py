"""Units of a maker's drive: the values of its factor objects, by its file and the lines of a configuration.

The order is that in which hil's master looks at a real drive
(``bridges/can/canopen/master/drive_units.py``), so that both sides
mean the same by the same file.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from bridges.can.canopen.cia402.drive_context import UserUnits
from bridges.can.canopen.master.drive_units import GivenUnits, UnitsUnknown, si_deg

_SI = (0x60A8, 0x60A9, 0x60AA)
_FEED, _GEAR, _COUNTS, _SPEED, _RAMP = 0x6092, 0x6091, 0x608F, 0x6096, 0x6097
_DEG_PER_TURN, _S_PER_MIN, _DEG_PER_S = 360.0, 60, 6.0
_FINEST = 10**9
"""Greatest divisor of a unit that is given as a number with a point."""
Factors = dict[tuple[int, int], int]
Given = Callable[[int, int], int | None]
"""Value that the file has of an object; None: none."""


def factors_of(given: Given, lines: GivenUnits) -> Factors:
    """Values of those factor objects that are not the drive's own objects.

    Raises:
        UnitsUnknown: neither the file nor the lines say how many units a turn has.
    """
    factors: Factors = {}
    per_turn = _position(factors, given, lines)
    speed = _speed(factors, given, lines, per_turn)
    _ramp(factors, given, lines, per_turn, speed)
    return factors


def contradictions(given: Given, lines: GivenUnits) -> str:
    """Units of the lines that are others than the file's own, in words; empty: none."""
    if lines.position_per_turn is None:
        return ""
    try:
        own = _position({}, given, replace(lines, position_per_turn=None))
    except UnitsUnknown:
        return ""
    if abs(float(own) / lines.position_per_turn - 1) < 1e-6:
        return ""
    return f"the file has {float(own):.10g} units a turn, and this is {lines.position_per_turn:.10g}"


def _position(factors: Factors, given: Given, lines: GivenUnits) -> Fraction:
    """Units of position in a turn of the motor."""
    gear = _ratio(given, _GEAR)
    if lines.position_per_turn is not None:
        per_turn = _set(factors, _FEED, Fraction(lines.position_per_turn).limit_denominator(_FINEST))
        return per_turn / _set(factors, _GEAR, Fraction(1))
    if gear is None:
        gear = _set(factors, _GEAR, Fraction(1))
    if unit_deg := _si(given, 0x60A8):
        return _set(factors, _FEED, Fraction(_DEG_PER_TURN / unit_deg).limit_denominator(_FINEST)) / gear
    feed = _ratio(given, _FEED)
    if feed is not None and feed > 1:  # a drive that has no use for it says 1
        return feed / gear
    counts = _ratio(given, _COUNTS)
    if counts is not None and counts > 1:
        return _set(factors, _FEED, counts) / _set(factors, _GEAR, Fraction(1))
    raise UnitsUnknown("the file does not say how many units a turn has (6092h, 608Fh, 60A8h)")


def _speed(factors: Factors, given: Given, lines: GivenUnits, per_turn: Fraction) -> Fraction | None:
    """Units of speed of a position unit a second; None: the drive's own object."""
    if lines.velocity_per_rpm is not None:
        per_rpm = Fraction(lines.velocity_per_rpm).limit_denominator(_FINEST)
    elif unit_deg := _si(given, 0x60A9):
        per_rpm = Fraction(_DEG_PER_S / unit_deg).limit_denominator(_FINEST)
    elif lines.position_per_turn is None and _ratio(given, _SPEED) is not None:
        return None
    else:
        return _set(factors, _SPEED, Fraction(1))
    return _set(factors, _SPEED, per_rpm * _S_PER_MIN / per_turn)


def _ramp(
    factors: Factors, given: Given, lines: GivenUnits, per_turn: Fraction, speed: Fraction | None
) -> None:
    """Units of acceleration of a position unit a second squared."""
    if lines.acceleration_per_rpm_per_s is not None:
        per_rpm = Fraction(lines.acceleration_per_rpm_per_s).limit_denominator(_FINEST)
    elif lines.velocity_per_rpm is None and (unit_deg := _si(given, 0x60AA)):
        per_rpm = Fraction(_DEG_PER_S / unit_deg).limit_denominator(_FINEST)
    elif lines == GivenUnits() and _ratio(given, _RAMP) is not None:
        return
    else:
        _set(factors, _RAMP, speed or Fraction(1))
        return
    _set(factors, _RAMP, per_rpm * _S_PER_MIN / per_turn)


def _set(factors: Factors, index: int, ratio: Fraction) -> Fraction:
    factors[index, 1], factors[index, 2] = ratio.numerator, ratio.denominator
    return ratio


def _ratio(given: Given, index: int) -> Fraction | None:
    top, below = given(index, 1), given(index, 2)
    if not top or top < 0 or (below is not None and below <= 0):
        return None
    return Fraction(top, below or 1)


def _si(given: Given, index: int) -> float | None:
    return si_deg({(each, 0): given(each, 0) or 0 for each in _SI}, index)


@dataclass(frozen=True)
class DefaultScale:
    """Scale of defaults of hil's own drive, which are in thousandths of a degree, in the units of another."""

    units: UserUnits

    def of(self, index: int, value: int) -> int:
        """Value of an object in these units; unchanged if it is no position, speed or acceleration."""
        if index in _POSITIONS:
            per_unit = abs(self.units.deg / self.units.per_deg)
        elif index in _SPEEDS:
            per_unit = abs(self.units.deg_per_s)
        elif index in _RAMPS:
            per_unit = self.units.deg_per_s2
        else:
            return value
        return max(round(value / 1000 / per_unit), 1)


_POSITIONS = frozenset((0x6065, 0x6067))
_SPEEDS = frozenset((0x606D, 0x606F, 0x607F, 0x6081, 0x6099))
_RAMPS = frozenset((0x6083, 0x6084, 0x6085, 0x609A, 0x60A4))


def units_with(factors: Mapping[tuple[int, int], int], given: Given) -> UserUnits:
    """Units by fixed factors, and by the file's values of the others."""

    def value(index: int, subindex: int) -> int:
        found = factors.get((index, subindex))
        own = given(index, subindex) if found is None else found
        return (0 if index == 0x607E else 1) if own is None else own

    return UserUnits.made(value, 0.0)
