"""Files of ``hil gcode``: a program and a machine, read, checked and planned; what is told of them."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hil.cli.framework.ask import fail
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.shown_words import counted, fixed

if TYPE_CHECKING:
    from hil.gcode.canonical import Point, Program
    from hil.toolpath.machine import Machine
    from hil.toolpath.path_plan import PathPlan

_POSITION = re.compile(r"([a-zA-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))")
MOST_BYTES = 1 << 28
"""Largest program."""


class PlannedFile(NamedTuple):
    """Program of a file, its machine, and the plan."""

    program: "Program"
    machine: "Machine"
    plan: "PathPlan"


def planned_file(
    file: Path, machine_file: Path, at: str, *, override: float = 1.0, is_block_delete: bool = False
) -> PlannedFile:
    """Read and plan a program; all problems of both files end the command."""
    machine = read_machine(machine_file, file)
    return planned_at(
        file, machine, position_of(at, machine), override=override, is_block_delete=is_block_delete
    )


def planned_at(
    file: Path, machine: "Machine", begin: "Point", *, override: float = 1.0, is_block_delete: bool = False
) -> PlannedFile:
    """Read and plan a program for a machine that stands there; all its problems end the command."""
    from hil.gcode.canonical import Settings
    from hil.gcode.reader import read_program
    from hil.toolpath.path_plan import plan_program

    settings = Settings(str(file), begin, is_block_delete=is_block_delete)
    program = read_program(_bytes_of(file), settings)
    plan = plan_program(program, machine, str(file), begin, override)
    if plan.problems:
        raise fail("\n".join(map(str, plan.problems)), Exit.MISTAKE)
    return PlannedFile(program, machine, plan)


def read_machine(file: Path, program: Path) -> "Machine":
    """Read a machine's document; its problems end the command, with those of the program for it."""
    from hil.gcode.canonical import Settings
    from hil.gcode.reader import read_program
    from hil.toolpath.machine import parse_machine
    from hil.vocab.problem import ConfigError, not_text

    try:
        return parse_machine(_bytes_of(file).decode("utf-8"), str(file))
    except UnicodeDecodeError as error:
        raise fail(str(not_text(str(file), error)), Exit.MISTAKE) from None
    except ConfigError as error:
        read = read_program(_bytes_of(program), Settings(str(program)), is_somewhere=True)
        raise fail("\n".join(map(str, [*error.problems, *read.problems])), Exit.MISTAKE) from None


def position_of(text: str, machine: "Machine") -> "Point":
    """Read where a machine stands, as in ``X10 Y-2.5``; axes that are left out are at 0, or at their end that
    is nearest to it. Ends the command: it is no position of this machine."""
    from hil.gcode.canonical import Point

    places = {axis.letter: min(max(0.0, axis.minimum), axis.maximum) for axis in machine.axes}
    if _POSITION.sub("", text).strip():
        raise fail(f"hil: --at {text!r} is no position: write it as X10 Y-2.5", Exit.MISTAKE)
    for letter, number in _POSITION.findall(text):
        if letter.lower() not in places:
            raise fail(f"hil: --at: the machine has no axis {letter.upper()}", Exit.MISTAKE)
        places[letter.lower()] = float(number)
    return Point(**places)


def _bytes_of(file: Path) -> bytes:
    try:
        if file.is_file() and file.stat().st_size > MOST_BYTES:
            raise fail(f"hil: {file}: a program has at most {MOST_BYTES >> 20} MiB", Exit.MISTAKE)
        return file.read_bytes()
    except OSError as error:
        raise fail(f"hil: {file}: {error.strerror}", Exit.MISTAKE) from None


def figures_of(file: Path, planned: PlannedFile) -> dict[str, Any]:
    """Figures of a plan, for JSON."""
    program, machine, plan = planned
    stretches = list(plan.stretches)
    load = plan.line_load
    return {
        "file": str(file),
        "machine": machine.name,
        "lines": program.line_count,
        "motions": len(program.motions),
        "duration_s": round(plan.duration_s, 3),
        "feed_mm": round(plan.length(is_rapid=False), 3),
        "rapid_mm": round(plan.length(is_rapid=True), 3),
        "range": {axis: [round(end, 6) for end in ends] for axis, ends in plan.extents().items()},
        "streams": sum(each.is_streamed for each in stretches),
        "ramped_lines": sum(len(each.stretch.chords) for each in stretches if not each.is_streamed),
        "line": load
        and {
            "baud": machine.text.baud,
            "needed_per_s": round(load.needed_per_s, 1),
            "possible_per_s": round(load.possible_per_s, 1),
            "margin_ms": round(min(load.margin_s, 1e6) * 1000),
            "keeps_up": load.keeps_up,
        },
        "remarks": [
            {"line": each.line, "column": each.column, "message": each.message, "remedy": each.remedy}
            for each in (*program.remarks, *plan.remarks)
        ],
    }


def figures_text(figures: dict[str, Any], machine: "Machine") -> str:
    """Figures of a plan, for people."""
    motions, remarks = counted(figures["motions"], "motion"), len(figures["remarks"])
    said = f", {counted(remarks, 'remark')}" if remarks else ""
    lines = [f"{figures['file']}: {counted(figures['lines'], 'line')}, {motions}, no problems{said}"]
    feed, rapid = fixed(figures["feed_mm"], 1), fixed(figures["rapid_mm"], 1)
    lines.append(f"  way: {feed} mm at a feed, {rapid} mm rapid; time: {fixed(figures['duration_s'], 1)} s")
    units = {axis.letter: axis.unit for axis in machine.axes}
    ranges = [
        f"{axis.upper()} {low:g} to {high:g} {units[axis]}" for axis, (low, high) in figures["range"].items()
    ]
    lines.append(f"  range: {', '.join(ranges)}")
    streams, ramped = counted(figures["streams"], "stretch"), counted(figures["ramped_lines"], "line")
    streams = streams if figures["streams"] == 1 else streams.replace("stretchs", "stretches")
    lines.append(f"  {streams} in short segments, {ramped} with ramps")
    if load := figures["line"]:
        lines.append(
            f"  line: {load['needed_per_s']:g} commands a second at most, {load['possible_per_s']:g} can be"
            f" at {load['baud']} baud; each is {load['margin_ms']} ms early at least"
        )
    return "\n".join(lines)


def check_line(planned: PlannedFile) -> None:
    """End the command if the line cannot keep up with the plan."""
    from hil.toolpath.line_load import command_s

    load, machine = planned.plan.line_load, planned.machine
    if load is None or load.keeps_up:
        return
    least_ms = machine.text.segment_ms * max(load.needed_per_s / load.possible_per_s, 1.05)
    raise fail(
        f"hil: {planned.plan.file}: the line cannot keep up: it needs {load.needed_per_s:g} commands a second"
        f" and can do {load.possible_per_s:.0f} at {machine.text.baud} baud,"
        f" {command_s(machine) * 1000:.1f} ms each; one would come {-load.margin_s * 1000:.0f} ms late."
        f" Write segment_ms: {least_ms:.0f} or more in the machine, or a lower feed",
        Exit.MISTAKE,
    )


def remarks_of(planned: PlannedFile) -> list[str]:
    """Remarks on a program and its plan."""
    return [str(each) for each in (*planned.program.remarks, *planned.plan.remarks)]
