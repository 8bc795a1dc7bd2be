"""Arcs in a plane: the centre that a radius gives, and whether a centre fits both ends."""

from math import atan2, hypot, sqrt, tau
from typing import NamedTuple

Spot = tuple[float, float]
"""Point of a plane: its first and second axis, in millimetres."""


LEAST_ANGLE = 1e-6
"""Radians; LinuxCNC 2.9 makes a whole circle of less."""


class ArcTolerance(NamedTuple):
    """Limits of LinuxCNC 2.9, as measured with its interpreter, in millimetres."""

    radius_mm: float
    """Smaller radii count as 0, and a radius may be too short for the ends by this."""
    always_mm: float
    """Radii at both ends may differ by this."""
    share: float = 1e-3
    """They may differ by this share of the larger one, too."""
    never_mm: float = 0.0
    """They may never differ by more."""


TOLERANCE_MM = ArcTolerance(0.00127, 0.02 * sqrt(2), never_mm=2 * sqrt(2))
"""With G21."""

TOLERANCE_INCH = ArcTolerance(0.00127, 0.0508 * sqrt(2), never_mm=5.08 * sqrt(2))
"""With G20: 0.00005 inches, and twice the root of 2 in thousandths of an inch."""


class ArcMistake(Exception):
    """An arc that cannot be: message and remedy."""

    def __init__(self, message: str, remedy: str) -> None:
        super().__init__(message)
        self.message = message
        self.remedy = remedy


def centre_by_radius(begin: Spot, end: Spot, radius: float, is_clockwise: bool, within: ArcTolerance) -> Spot:
    """Centre of an arc of at most half a turn, or of more if ``radius`` is below 0."""
    across, up = end[0] - begin[0], end[1] - begin[1]
    chord = hypot(across, up)
    if chord == 0:
        raise ArcMistake("an arc with R ends where it begins", "give its centre with I J K, or another end")
    if chord / 2 > abs(radius) + within.radius_mm:
        remedy = f"half the way between them is {chord / 2:.6g} mm"
        raise ArcMistake(f"the radius, {abs(radius):.6g} mm, is too short for both ends", remedy)
    # The root of a difference of squares, in the form that loses least.
    aside = sqrt(max(0.0, (abs(radius) - chord / 2) * (abs(radius) + chord / 2))) / chord
    if is_clockwise == (radius < 0):
        aside = -aside
    return begin[0] + across / 2 + up * aside, begin[1] + up / 2 - across * aside


def check_sweep(begin: Spot, end: Spot, centre: Spot, *, is_clockwise: bool) -> None:
    """Raise ``ArcMistake`` for an arc of almost no angle: a whole circle may be meant, or nothing."""
    if begin == end:
        return
    angle = atan2(end[1] - centre[1], end[0] - centre[0]) - atan2(begin[1] - centre[1], begin[0] - centre[0])
    if (-angle if is_clockwise else angle) % tau < LEAST_ANGLE:
        remedy = "end a whole circle where it begins, to the last digit"
        raise ArcMistake("the arc ends almost where it begins: a whole circle, or none?", remedy)


def check_centre(begin: Spot, end: Spot, centre: Spot, within: ArcTolerance) -> None:
    """Raise ``ArcMistake`` if the ends are not equally far from the centre, within the tolerance."""
    first = hypot(begin[0] - centre[0], begin[1] - centre[1])
    last = hypot(end[0] - centre[0], end[1] - centre[1])
    if min(first, last) < within.radius_mm:
        where = "begins" if first <= last else "ends"
        raise ArcMistake(f"the arc {where} in its centre", "change I J K, or the end")
    apart = abs(first - last)
    if apart > within.never_mm or (apart > within.always_mm and apart > within.share * max(first, last)):
        remedy = f"they differ by {apart:.4g} mm: change I J K, or the end"
        raise ArcMistake(
            f"the arc's radius is {first:.6g} mm at its begin and {last:.6g} mm at its end", remedy
        )
