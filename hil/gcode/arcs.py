"""Arcs in a plane: the centre that words or a radius give, a check that it fits both ends, and the turns."""

from math import atan2, hypot, sqrt, tau

from hil.gcode.block import Block
from hil.gcode.canonical import PLANE_AXES, Arc, Feed, Point, TextPlace
from hil.gcode.expressions import WHOLE
from hil.gcode.state import ArcTolerance, ProgramState
from hil.gcode.words import AXES

Spot = tuple[float, float]
"""Point of a plane: its first and second axis, in millimetres."""
LEAST_ANGLE = 1e-6
"""Radians; LinuxCNC 2.9 makes a whole circle of less."""
_OFFSETS = "ijk"


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


def arc_of(
    block: Block, state: ProgramState, place: TextPlace, end: Point, feed: Feed, *, is_clockwise: bool
) -> Arc:
    """Arc from where the axes are to ``end``. Raises ``ArcMistake``, for words that are missing, too."""
    first, second, across = PLANE_AXES[state.plane]
    begin = state.position[first], state.position[second]
    to = end[first], end[second]
    given = [letter for letter in _OFFSETS if letter in block.numbers]
    if _OFFSETS[across] in given:
        name, axis = _OFFSETS[across].upper(), AXES[across].upper()
        raise ArcMistake(f"{name} is the centre along {axis}, which is not in the plane", _in_plane(state))
    if "r" in block.numbers:
        if given:
            raise ArcMistake("the arc has R, and a centre too", "give one of them")
        if AXES[first] not in block.numbers and AXES[second] not in block.numbers:
            raise ArcMistake(
                "an arc with R has no end in its plane", "give its end, or its centre with I J K"
            )
        radius = block.numbers["r"] * state.units.mm
        centre = centre_by_radius(begin, to, radius, is_clockwise, state.units.tolerance)
    elif not given:
        raise ArcMistake("the arc has neither a centre nor a radius", _in_plane(state))
    else:
        if state.is_arc_absolute and len(given) < 2:
            raise ArcMistake("with G90.1 an arc needs both numbers of its centre", _in_plane(state))
        centre = _along(block, state, first), _along(block, state, second)
        check_centre(begin, to, centre, state.units.tolerance)
    check_sweep(begin, to, centre, is_clockwise=is_clockwise)
    return Arc(place, state.plane, end, centre, -_turns(block) if is_clockwise else _turns(block), feed)


def _along(block: Block, state: ProgramState, index: int) -> float:
    number = block.numbers.get(_OFFSETS[index], 0.0) * state.units.mm
    return number + (state.offset if state.is_arc_absolute else state.position)[index]


def _in_plane(state: ProgramState) -> str:
    first, second = sorted(PLANE_AXES[state.plane][:2])
    return f"in the plane {state.plane.upper()} give {_OFFSETS[first].upper()} and {_OFFSETS[second].upper()}"


def _turns(block: Block) -> int:
    if "p" not in block.numbers or block.has("G4") or block.has("G64"):
        return 1
    turns = round(block.numbers["p"])
    if turns < 1 or abs(block.numbers["p"] - turns) > WHOLE:
        raise ArcMistake("P is not a number of turns", "write 1, 2, ... or remove P")
    return turns
