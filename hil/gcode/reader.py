"""Programs in G-code, from their bytes to canonical motions and problems."""

import re

from hil.gcode.canonical import End, Point, Program, Settings, Straight, TextPlace
from hil.gcode.expressions import NUMBER
from hil.gcode.interpreter import NOWHERE, SLOWEST, Interpreter
from hil.gcode.program_text import LONGEST, CodeLine, lines_of
from hil.gcode.words import AXES
from hil.vocab.problem import Problem

MOST_PROBLEMS = 1000
"""Reading ends with so many: a file that is no program has one in each line."""
_PLAIN = 1e8
"""Larger numbers are looked at closely."""
_BLANKS = r"[ \t]*+"
_LINE = re.compile(
    rf"{_BLANKS}(?:[Nn][0-9]++{_BLANKS})?([Gg]0?+[01]{_BLANKS})?"
    + "".join(rf"(?:[{letter}{letter.lower()}]({NUMBER}){_BLANKS})?" for letter in "XYZF")
    + r"\r*+\Z"
)


def read_program(text: bytes, settings: Settings | None = None, *, is_somewhere: bool = False) -> Program:
    """Read a program. All its problems are found, up to ``MOST_PROBLEMS``, each with its place and remedy.
    ``is_somewhere``: where the machine begins is not known, and nothing that depends on it is a problem."""
    settings = settings or Settings()
    lines, problems = lines_of(text, settings.file)
    if problems:
        return Program((), tuple(problems))
    interpreter = Interpreter(settings)
    if is_somewhere:
        interpreter.doubts.update(AXES)
    count = _read_lines(lines, interpreter)
    problems = interpreter.problems
    if interpreter.has_ended:
        interpreter.remarks += _behind_the_end(lines, count, settings.file)
    if not interpreter.has_ended and len(problems) < MOST_PROBLEMS:
        remedy = "end it with M2 or M30, or put % in its first and last line; was the file cut off?"
        column = len(lines[-1].rstrip()) + 1 if lines else 1
        problems.append(Problem(settings.file, max(len(lines), 1), column, "the program has no end", remedy))
    motions = () if problems else tuple(interpreter.motions)
    understood = tuple(interpreter.motions[: interpreter.understood_count])
    return Program(motions, tuple(problems[:MOST_PROBLEMS]), tuple(interpreter.remarks), count, understood)


def _read_lines(lines: list[str], interpreter: Interpreter) -> int:
    """Read lines up to the end of the program. Answers how many they are."""
    first = next((number for number, raw in enumerate(lines, 1) if raw.strip()), 0)
    is_marked = bool(first) and lines[first - 1].strip() == "%"
    for number, raw in enumerate(lines, 1):
        if _do_usual_line(interpreter, number, raw) or not raw.strip():
            continue
        if is_marked and raw.strip() == "%":
            if number == first:
                continue
            interpreter.motions.append(End(TextPlace(number, raw.index("%") + 1)))
            interpreter.has_ended = True
        else:
            interpreter.do(CodeLine(number, raw))
        if interpreter.has_ended or len(interpreter.problems) >= MOST_PROBLEMS:
            return number
    return len(lines)


def _behind_the_end(lines: list[str], count: int, file: str) -> list[Problem]:
    """Remark about lines behind the end of a program, if any says something."""
    for number, raw in enumerate(lines[count:], count + 1):
        if raw.strip() not in ("", "%"):
            column = len(raw) - len(raw.lstrip()) + 1
            message = f"this is behind the end of the program in line {count}: it is not read"
            return [Problem(file, number, column, message, "remove it, or the end")]
    return []


def _do_usual_line(interpreter: Interpreter, number: int, raw: str) -> bool:
    """Carry out a line if it is a usual one and has no problem. Answers whether it was.

    CAM programs have these most: G0 or G1, or neither, and X Y Z F in this order. It takes a few
    microseconds, and does what ``Interpreter.do`` does, to which all else is left.
    """
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
        place = TextPlace(number, begin + (1 if g is not None else 0))
        is_rapid = motion == "G0"
        end = Point(*position)
        interpreter.motions.append(Straight(place, is_rapid, end, None if is_rapid else state.linear_feed))
    return True
