"""Words of an arc to an ``Arc``: its centre and its turns."""

from hil.gcode.arcs import ArcMistake, centre_by_radius, check_centre, check_sweep
from hil.gcode.block import Block
from hil.gcode.canonical import PLANE_AXES, Arc, Feed, Place, Point
from hil.gcode.expressions import WHOLE
from hil.gcode.state import ProgramState
from hil.gcode.words import AXES

_OFFSETS = "ijk"


def arc_of(
    block: Block, state: ProgramState, place: Place, end: Point, feed: Feed, *, is_clockwise: bool
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
