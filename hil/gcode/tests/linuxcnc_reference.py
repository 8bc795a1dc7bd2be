"""LinuxCNC's own interpreter as a reference: its program ``rs274`` (Debian's ``linuxcnc-uspace``).

It prints the canonical calls of a program with four decimals. A small library, loaded before libc's, has it
print twelve.

``linuxcnc_outcomes.jsonl`` has what ``rs274`` of Debian's linuxcnc-uspace 2.9.0~pre1 made of programs that
we wrote, a JSON object a line: the program's text, its file in ``examples/gcode`` or its seed, and the
first line that is refused, or items, in millimetres, rounded to 1e-7. ``python linuxcnc_reference.py``
writes it again.
"""

import json
import re
import shutil
import subprocess
from collections.abc import Iterable, Iterator
from math import atan2, hypot, tau
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from chance_programs import program

from hil.gcode.canonical import (
    PLANE_AXES,
    Arc,
    Canonical,
    Dwell,
    End,
    Message,
    PathMode,
    Pause,
    Plane,
    Program,
    Straight,
    Switch,
)

OUTCOMES = Path(__file__).with_name("linuxcnc_outcomes.jsonl")
EXAMPLES = Path(__file__).parents[3] / "examples" / "gcode"

_MORE_DECIMALS = """
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
int __vfprintf_chk(FILE *file, int flag, const char *format, va_list values)
{
    char longer[1024];
    size_t used = 0;
    (void)flag;
    while (*format && used + 8 < sizeof longer) {
        if (!strncmp(format, "%.4f", 4) || !strncmp(format, "%f", 2)) {
            memcpy(longer + used, "%.12f", 5);
            used += 5;
            format += format[1] == '.' ? 4 : 2;
        } else {
            longer[used++] = *format++;
        }
    }
    longer[used] = 0;
    return vfprintf(file, longer, values);
}
int __fprintf_chk(FILE *file, int flag, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    int count = __vfprintf_chk(file, flag, format, values);
    va_end(values);
    return count;
}
"""
_CALL = re.compile(r"\s*\d+ +N\S* +(\w+)\((.*)\)$")
_PLANES: dict[str, Plane] = {"CANON_PLANE_XY": "xy", "CANON_PLANE_XZ": "xz", "CANON_PLANE_YZ": "yz"}
_PATHS = {"EXACT_PATH": "exact_path", "EXACT_STOP": "exact_stop", "CONTINUOUS": "blend"}
_TIME_OUT_S = 20

RARE = 0.005
"""Share of rare lines in the programs that are stored by their seed."""

Item = tuple[object, ...]
"""Actions in order, each with the states of spindle, mist and flood during it."""


class Outcome(NamedTuple):
    """Result of a reader for a program: items, or the first line that it refuses."""

    items: list[Item]
    refused: str | None
    message: str = ""


class Stored(NamedTuple):
    """A row of ``OUTCOMES``: which program, its text, and what LinuxCNC made of it."""

    key: dict[str, object]
    text: bytes
    outcome: Outcome


def stored() -> list[Stored]:
    rows = []
    for row in map(json.loads, OUTCOMES.read_text().splitlines()):
        outcome = Outcome([_tuples(item) for item in row.pop("items", [])], row.pop("refused", None))
        rows.append(Stored(row, _text(row), outcome))
    return rows


def _text(key: dict[str, object]) -> bytes:
    match key:
        case {"program": str(text)}:
            return text.encode()
        case {"file": str(name)}:
            return (EXAMPLES / name).read_bytes()
        case {"seed": int(seed)}:
            return program(seed, RARE).encode()
    raise ValueError(key)


def _tuples(value: object) -> object:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _rounded(value: object) -> object:
    if isinstance(value, tuple):
        return tuple(map(_rounded, value))
    return round(value, 7) if isinstance(value, float) else value


def write(rows: Iterable[dict[str, object]], reference: "Reference") -> None:
    """Write what the reference makes of programs to ``OUTCOMES``."""
    lines = []
    for row in rows:
        outcome = reference.read(_text(row))
        made = {"refused": outcome.refused} if outcome.refused else {"items": _rounded((*outcome.items,))}
        lines.append(json.dumps(row | made) + "\n")
    OUTCOMES.write_text("".join(lines))


def is_here() -> bool:
    return bool(shutil.which("rs274") and shutil.which("cc"))


class Reference:
    """LinuxCNC's interpreter, in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._library = folder / "more_decimals.so"
        source = folder / "more_decimals.c"
        source.write_text(_MORE_DECIMALS)
        subprocess.run(["cc", "-shared", "-fPIC", "-o", self._library, source], check=True)

    def read(self, text: bytes) -> Outcome:
        """Read a program, which must have an end: the interpreter waits for ever otherwise."""
        path = self._folder / "program.ngc"
        path.write_bytes(text)
        done = subprocess.run(
            ["rs274", "-g", path.name],
            cwd=self._folder,
            env={"LD_PRELOAD": str(self._library), "PATH": "/usr/bin:/bin"},
            capture_output=True,
            timeout=_TIME_OUT_S,
            check=False,
        )
        said = done.stderr.decode(errors="surrogateescape").removeprefix("executing\n")
        lines = [line for line in said.splitlines() if line.strip()]
        items = list(_items(done.stdout.decode(errors="surrogateescape").splitlines()))
        if lines:
            return Outcome(items, lines[-1].strip(), lines[0])
        return Outcome(items, None)


def outcome_of(read: Program, text: bytes) -> Outcome:
    """Read a program with our reader, in the form of the reference."""
    if read.problems:
        problem = read.problems[0]
        lines = text.decode(errors="surrogateescape").split("\n")
        return Outcome([], lines[problem.line - 1].strip(), str(problem))
    return Outcome(list(_own_items(read.motions)), None)


def differences(ours: Outcome, theirs: Outcome) -> list[str]:
    """Find the first difference of two outcomes."""
    if ours.refused is not None or theirs.refused is not None:
        if ours.refused == theirs.refused:
            return []
        return [
            f"ours refuses {ours.refused!r}: {ours.message}; LinuxCNC {theirs.refused!r}: {theirs.message}"
        ]
    for one, other in zip(ours.items, theirs.items, strict=False):
        if not is_same(one, other):
            return [f"ours {one}, LinuxCNC {other}"]
    if len(ours.items) != len(theirs.items):
        return [f"ours has {len(ours.items)} items, LinuxCNC {len(theirs.items)}"]
    return []


def is_same(one: object, other: object) -> bool:
    """True if two items are equal, numbers by a millionth or 1e-9 of their size."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(is_same, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= max(1e-6, 1e-9 * max(abs(one), abs(other)))
    return one == other


def arc_length(
    begin: tuple[float, ...], arc: tuple[Plane, tuple[float, ...], tuple[float, float], int]
) -> float:
    """Length of a helix from a point."""
    plane, end, centre, turns = arc
    first, second, across = PLANE_AXES[plane]
    start = atan2(begin[second] - centre[1], begin[first] - centre[0])
    stop = atan2(end[second] - centre[1], end[first] - centre[0])
    angle = (stop - start if turns > 0 else start - stop) % tau
    if angle < 1e-9 or tau - angle < 1e-9:
        angle = tau
    angle += tau * (abs(turns) - 1)
    radius = hypot(begin[first] - centre[0], begin[second] - centre[1])
    return hypot(radius * angle, end[across] - begin[across])


def _own_items(motions: Iterable[Canonical]) -> Iterator[Item]:
    spindle: tuple[str, float] = ("off", 0.0)
    coolant = {"mist": "off", "flood": "off"}
    here: tuple[float, ...] = (0.0,) * 6
    for motion in motions:
        after = (spindle, coolant["mist"], coolant["flood"])
        match motion:
            case Straight(_, is_rapid, end, feed):
                rate = None
                if feed is not None:
                    length = hypot(*(end[i] - here[i] for i in range(3))) or hypot(
                        *(end[i] - here[i] for i in range(3, 6))
                    )
                    is_time = feed.kind == "inverse_time"
                    rate = ("per_minute", feed.value * length) if is_time else (feed.kind, feed.value)
                here = tuple(end[:6])
                yield ("straight", is_rapid, here, rate, *after)
            case Arc(_, plane, end, centre, turns, feed):
                to = tuple(end[:6])
                is_time = feed.kind == "inverse_time"
                length = arc_length(here, (plane, to, centre, turns))
                rate = ("per_minute", feed.value * length) if is_time else (feed.kind, feed.value)
                here = to
                yield ("arc", plane, to, centre, turns, rate, *after)
            case Dwell(_, seconds):
                yield ("dwell", seconds, *after)
            case Switch(_, "spindle", state, speed_rpm):
                spindle = (state, speed_rpm or 0.0)
            case Switch(_, name, state, _):
                coolant[name] = state
            case Pause(_, is_optional):
                yield ("pause", is_optional, *after)
            case PathMode(_, kind, tolerance_mm):
                yield ("path", kind, tolerance_mm or 0.0)
            case Message(_, text):
                if not text.startswith("change to tool"):
                    yield ("message", text)
            case End():
                pass


def _items(lines: Iterable[str]) -> Iterator[Item]:
    mm = 1.0
    system, shift = [0.0] * 6, [0.0] * 6
    kind, rate, plain = "per_minute", 0.0, 0.0
    plane: Plane = "xy"
    speed_rpm, direction = 0.0, "off"
    coolant = {"MIST": "off", "FLOOD": "off"}
    here: tuple[float, ...] = (0.0,) * 6
    for line in lines:
        found = _CALL.match(line)
        if not found:
            continue
        call, inside = found.groups()
        values = [float(each) for each in re.findall(r"-?\d+\.\d+|-?\d+", inside)]
        after = ((direction, speed_rpm if direction != "off" else 0.0), coolant["MIST"], coolant["FLOOD"])

        def machine(numbers: list[float]) -> list[float]:
            return [
                number * (mm if index < 3 else 1.0) + system[index] + shift[index]  # noqa: B023
                for index, number in enumerate(numbers)
            ]

        match call:
            case "USE_LENGTH_UNITS":
                mm = 25.4 if "INCHES" in inside else 1.0
            case "SET_G5X_OFFSET":
                system = [v * (mm if i < 3 else 1.0) for i, v in enumerate(values[1:7])]
            case "SET_G92_OFFSET":
                shift = [v * (mm if i < 3 else 1.0) for i, v in enumerate(values[:6])]
            case "SELECT_PLANE":
                plane = _PLANES.get(inside, "xy")
            case "SET_FEED_MODE":
                kind = "per_revolution" if values[1] else "per_minute"
            case "SET_FEED_RATE":
                rate, plain = values[0] * mm, values[0]
            case "STRAIGHT_TRAVERSE" | "STRAIGHT_FEED":
                end = tuple(machine(values))
                if end != here:
                    is_rapid = call == "STRAIGHT_TRAVERSE"
                    is_linear = any(abs(end[i] - here[i]) > 1e-9 for i in range(3))
                    feed = None if is_rapid else (kind, rate if is_linear else plain)
                    if any(abs(a - b) > 1e-9 for a, b in zip(end, here, strict=True)):
                        yield ("straight", is_rapid, end, feed, *after)
                here = end
            case "ARC_FEED":
                first, second, across = PLANE_AXES[plane]
                place = [0.0] * 6
                place[first], place[second], place[across] = values[0], values[1], values[5]
                place[3:] = values[6:9]
                middle = [0.0] * 6
                middle[first], middle[second] = values[2], values[3]
                centre = machine(middle)
                end = tuple(machine(place))
                yield (
                    "arc", plane, end, (centre[first], centre[second]), int(values[4]), (kind, rate), *after,
                )  # fmt: skip
                here = end
            case "DWELL":
                yield ("dwell", values[0], *after)
            case "SET_SPINDLE_SPEED":
                speed_rpm = values[1]
            case "START_SPINDLE_CLOCKWISE":
                direction = "cw"
            case "START_SPINDLE_COUNTERCLOCKWISE":
                direction = "ccw"
            case "STOP_SPINDLE_TURNING":
                direction = "off"
            case "MIST_ON" | "MIST_OFF" | "FLOOD_ON" | "FLOOD_OFF":
                name, _, to = call.partition("_")
                coolant[name] = to.lower()
            case "PROGRAM_STOP" | "CHANGE_TOOL" | "OPTIONAL_PROGRAM_STOP":
                yield ("pause", call == "OPTIONAL_PROGRAM_STOP", *after)
            case "SET_MOTION_CONTROL_MODE":
                tolerance = values[0] * mm if values else 0.0
                yield ("path", next(k for name, k in _PATHS.items() if name in inside), tolerance)
            case "MESSAGE":
                yield ("message", inside[1:-1].strip())
            case _:
                pass


if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        write((row.key for row in stored()), Reference(Path(folder)))
