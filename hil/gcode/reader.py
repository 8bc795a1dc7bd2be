"""Programs in G-code, from their bytes to canonical motions and problems."""

from hil.gcode.canonical import End, Place, Program, Settings
from hil.gcode.interpreter import Interpreter
from hil.gcode.program_text import CodeLine, lines_of
from hil.gcode.usual_lines import do_usual_line
from hil.gcode.words import AXES
from hil.vocab.problem import Problem

MOST_PROBLEMS = 1000
"""Reading ends with so many: a file that is no program has one in each line."""


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
        if do_usual_line(interpreter, number, raw) or not raw.strip():
            continue
        if is_marked and raw.strip() == "%":
            if number == first:
                continue
            interpreter.motions.append(End(Place(number, raw.index("%") + 1)))
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
