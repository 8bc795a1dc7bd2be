"""Drawing: a program in G-code, read, checked and planned for the axes of a bench. Nothing moves."""

import asyncio
from collections.abc import Callable, Mapping
from typing import Any

from hil.gcode.canonical import Arc, Point, Program, Settings, Straight
from hil.gcode.reader import read_program
from hil.operations.table import Asked
from hil.toolpath.bench_runs import BenchRuns, machine_problems
from hil.toolpath.deviation import FINE_MM
from hil.toolpath.machine import Machine, parse_machine
from hil.toolpath.motion_check import arc_points
from hil.toolpath.path_plan import PathPlan, plan_path
from hil.vocab.axis import Axes, AxisNow
from hil.vocab.problem import ConfigError, Problem
from hil.vocab.verbs import Role, VerbRefused

DRAWING_CHARACTERS = 4 << 20
MACHINE_CHARACTERS = 64 << 10
MOST_POINTS = 100_000
"""Maximum number of points of a path that is told."""
MOST_WAITING = 4
"""Maximum number of drawings that wait for their turn: each takes a thread for a second or more."""
LISTED = 1000
"""Maximum number of problems, and of remarks, that are told."""


class DrawingOperation:
    """Plans drawings, one after the other, in a thread."""

    def __init__(self, axes: Axes) -> None:
        self._axes = axes
        self._waiting = 0
        self._last: dict[str, Any] | None = None
        self._turn = asyncio.Lock()

    def drawing(
        self, asked: Asked, text: str, machine: str, file: str, machine_file: str, feed_percent: float
    ) -> Any:
        """Read, check and plan a program; a coroutine of the answer. Without a program and a machine: the
        last drawing of an operator, with its texts, so that all who look on see it."""
        if not text and not machine:
            if self._last is None:
                raise VerbRefused("not_now", "this bench has no drawing yet")
            return self._last
        for name, given, most in (
            ("text", text, DRAWING_CHARACTERS),
            ("machine", machine, MACHINE_CHARACTERS),
        ):
            if len(given) > most:
                raise VerbRefused("bad_request", f"{name}: {len(given)} characters; {most} are the most")
        if self._waiting >= MOST_WAITING:
            raise VerbRefused("not_now", f"{self._waiting} drawings are being planned; ask again later")
        axes, override = self._axes.axes(), feed_percent / 100
        told = {"text": text, "machine_text": machine, "file": file, "feed_percent": feed_percent}

        def plan() -> dict[str, Any]:
            return planned_drawing(text, machine, file, machine_file, override, axes)

        return self._planned(plan, told if asked.source.role >= Role.OPERATOR else None)

    async def _planned(
        self, plan: Callable[[], dict[str, Any]], told: Mapping[str, Any] | None
    ) -> dict[str, Any]:
        self._waiting += 1
        try:
            async with self._turn:
                answer = await asyncio.get_running_loop().run_in_executor(None, plan)
                if told is not None and not answer["problems"]:
                    self._last = {**answer, **told}
                return answer
        finally:
            self._waiting -= 1


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
    if program.problems:
        return _refused("program", program.problems)
    plan = plan_path(program.motions, machine, file, begin, override)
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
    """Where a machine stands, by its axes' set-points."""
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
        if count >= MOST_POINTS:
            is_whole = False
            break
        points = [motion.end] if isinstance(motion, Straight) else arc_points(here, motion, FINE_MM)
        first = count
        for point in points:
            places += [round(point[index], 4) for index in indices]
            count += 1
        if isinstance(motion, Straight) and motion.is_rapid:
            rapids.append([first, count])
        if not lines or lines[-1][1] != motion.place.line:
            lines.append([first, motion.place.line])
        here = motion.end
    return {"places": places, "count": count, "rapids": rapids, "lines": lines, "is_whole": is_whole}
