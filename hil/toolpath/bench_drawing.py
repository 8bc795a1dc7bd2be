"""Drawing: a program in G-code, read, checked and planned for the axes of a bench, as doors tell it."""

from collections.abc import Mapping
from itertools import islice
from typing import Any

from hil.gcode.canonical import Arc, Point, Program, Settings, Straight
from hil.gcode.reader import read_program
from hil.toolpath.bench_runs import BenchRuns, machine_problems
from hil.toolpath.deviation import FINE_MM
from hil.toolpath.machine import Machine, parse_machine
from hil.toolpath.motion_check import arc_points
from hil.toolpath.path_plan import PathPlan, plan_program
from hil.vocab.axis import AxisNow
from hil.vocab.problem import ConfigError, Problem

MOST_PIECES = 200_000
"""Maximum number of straight pieces of a drawing: 200 MB and ten seconds of planning. A run has 30,000 or
so, and a program may be several runs."""
MOST_POINTS = 100_000
"""Maximum number of points of a path that is told."""
LISTED = 1000
"""Maximum number of problems, and of remarks, that are told."""


def planned_drawing(
    text: str, machine_text: str, file: str, machine_file: str, override: float, axes: Mapping[str, AxisNow]
) -> dict[str, Any]:
    """Plan a program for axes as they stand: its problems, or figures, path and runs."""
    try:
        machine = parse_machine(machine_text, machine_file)
    except ConfigError as error:
        return _refused("machine", error.problems)
    if problems := machine_problems(machine, machine_file, axes):
        return _refused("machine", problems)
    begin = _begin(machine, axes)
    program = read_program(text.encode(errors="surrogatepass"), Settings(file, begin))
    plan = plan_program(program, machine, file, begin, override, MOST_PIECES)
    if plan.problems:
        return _refused("program", plan.problems)
    followers = {name for name, axis in axes.items() if axis.follows_paths}
    runs = BenchRuns(plan, axes)
    if runs.problems:
        return _refused("program", runs.problems)
    remarks = [*program.remarks, *plan.remarks, *runs.remarks]
    return {
        "problems": [],
        "remarks": [str(each) for each in remarks[:LISTED]],
        "machine": machine.name,
        "figures": _figures(program, plan, runs),
        "axes": [
            {
                "letter": axis.letter,
                "axis": axis.bench_axis,
                "unit": axis.unit,
                "deg_per_unit": axis.motor_deg_per_unit,
                "zero_deg": axis.zero_deg,
                "range": [axis.minimum, axis.maximum],
                "follows_paths": axis.bench_axis in followers,
            }
            for axis in machine.axes
        ],
        "path": _path(program, machine, begin),
        "runs": [
            {
                "text": run.text,
                "duration_s": round(run.duration_s, 3),
                "timeline": [list(each) for each in run.timeline],
                "pause_line": run.pause.place.line if run.pause else None,
            }
            for run in runs.runs
        ],
    }


def _begin(machine: Machine, axes: Mapping[str, AxisNow]) -> Point:
    """Point at which a machine stands, by its axes' set-points."""
    places = {
        axis.letter: (axes[str(axis.bench_axis)].position_deg - axis.zero_deg) / axis.motor_deg_per_unit
        for axis in machine.axes
    }
    return Point(**{letter: round(place, 6) for letter, place in places.items()})


def _refused(of: str, problems: Any) -> dict[str, Any]:
    listed: list[Problem] = list(problems)[:LISTED]
    return {"problems": [str(each) for each in listed], "of": of}


def _figures(program: Program, plan: PathPlan, runs: BenchRuns) -> dict[str, Any]:
    return {
        "lines": program.line_count,
        "motions": len(program.motions),
        "duration_s": round(sum(run.duration_s for run in runs.runs), 3),
        "feed_mm": round(plan.length(is_rapid=False), 3),
        "rapid_mm": round(plan.length(is_rapid=True), 3),
        "range": {letter: [round(end, 4) for end in ends] for letter, ends in plan.extents().items()},
    }


def _path(program: Program, machine: Machine, begin: Point) -> dict[str, Any]:
    """Path that is asked for, arcs as points: positions of all axes one after the other, the points of rapids
    (from, to), and at which point each line of the program begins."""
    indices = [axis.index for axis in machine.axes]
    places: list[float] = [round(begin[index], 4) for index in indices]
    count, here, rapids, lines = 1, begin, list[list[int]](), list[list[int]]()
    is_whole = True
    for motion in program.motions:
        if not isinstance(motion, Straight | Arc):
            continue
        points = iter([motion.end]) if isinstance(motion, Straight) else arc_points(here, motion, FINE_MM)
        first = count
        for point in islice(points, MOST_POINTS - count):
            places += [round(point[index], 4) for index in indices]
            count += 1
        if isinstance(motion, Straight) and motion.is_rapid:
            rapids.append([first, count])
        if not lines or lines[-1][1] != motion.place.line:
            lines.append([first, motion.place.line])
        if next(points, None) is not None:
            is_whole = False
            break
        here = motion.end
    return {"places": places, "count": count, "rapids": rapids, "lines": lines, "is_whole": is_whole}
