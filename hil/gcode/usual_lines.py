"""Lines that CAM programs have most, in a few microseconds: G0 or G1, or neither, and X Y Z F in this order.

What is done is what ``Interpreter.do`` does; anything else than a plain motion is left to it.
"""

import re

from hil.gcode.canonical import Place, Point, Straight
from hil.gcode.expressions import NUMBER
from hil.gcode.interpreter import NOWHERE, SLOWEST, Interpreter
from hil.gcode.program_text import LONGEST

_PLAIN = 1e8
"""Larger numbers are looked at closely."""

_BLANKS = r"[ \t]*+"
_LINE = re.compile(
    rf"{_BLANKS}(?:[Nn][0-9]++{_BLANKS})?([Gg]0?+[01]{_BLANKS})?"
    + "".join(rf"(?:[{letter}{letter.lower()}]({NUMBER}){_BLANKS})?" for letter in "XYZF")
    + r"\r*+\Z"
)


def do_usual_line(interpreter: Interpreter, number: int, raw: str) -> bool:
    """Carry out a line if it is a usual one and has no problem. Answers whether it was."""
    found = _LINE.match(raw) if len(raw) <= LONGEST else None
    if found is None:
        return False
    g, x_text, y_text, z_text, f_text = found.groups()
    state = interpreter.state
    motion = state.motion if g is None else "G1" if "1" in g else "G0"
    if interpreter.doubts or state.feed_kind != "per_minute" or motion not in ("G0", "G1"):
        return False
    mm, position = state.units.mm, state.position
    x_mm, y_mm, z_mm = position[:3]
    x_0, y_0, z_0 = position[:3] if state.is_incremental else state.offset[:3]
    if x_text is not None and abs((to := float(x_text) * mm + x_0) - x_mm) > NOWHERE:
        x_mm = to
    if y_text is not None and abs((to := float(y_text) * mm + y_0) - y_mm) > NOWHERE:
        y_mm = to
    if z_text is not None and abs((to := float(z_text) * mm + z_0) - z_mm) > NOWHERE:
        z_mm = to
    f = state.feed if f_text is None else float(f_text)
    is_plain = -_PLAIN < x_mm < _PLAIN and -_PLAIN < y_mm < _PLAIN and -_PLAIN < z_mm < _PLAIN
    if not is_plain or f >= _PLAIN or f < (SLOWEST if motion == "G1" else 0.0):
        return False
    if x_text is y_text is z_text is None:
        return False
    if f_text is not None:
        state.set_feed(f)
    state.motion = motion
    if position[:3] != [x_mm, y_mm, z_mm]:
        position[:3] = x_mm, y_mm, z_mm
        begin = min(found.start(group) for group in (1, 2, 3, 4) if found[group] is not None)
        place = Place(number, begin + (1 if g is not None else 0))
        is_rapid = motion == "G0"
        end = Point(*position)
        interpreter.motions.append(Straight(place, is_rapid, end, None if is_rapid else state.linear_feed))
    return True
