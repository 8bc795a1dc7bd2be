"""Plan of a program as runs of a bench: axes that follow paths go exactly along it.

A program becomes one run, or several: `mill`, or `mill_1`, `mill_2`. After each but the last is a pause (M0,
M1, M6), or the machine stands because a run's text is full. Axes that make ramps of their own, as a SAC's do,
are sent from end to end of the path's straight pieces.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt

from hil.gcode.canonical import Dwell, Pause, Switch, TextPlace
from hil.runs.path_rows import ROWS
from hil.runs.run_axis import LIMITS
from hil.runs.run_document import DOCUMENT_BYTES, STEPS
from hil.toolpath.machine import Machine, MachineAxis
from hil.toolpath.path_items import Chord, Position
from hil.toolpath.path_plan import PathPlan, PlannedStretch, planned
from hil.toolpath.path_speeds import ChordSpeed, limits_of, stretch_speeds
from hil.vocab.axis import AxisNow
from hil.vocab.parameters import plain
from hil.vocab.path import DEG_PER_S
from hil.vocab.problem import Problem

SPARE = 1.02
"""Factor on an axis's limits in a run: set-points are rounded to 32 bits, and rows to six decimals."""
MOST_IN_RUNS = {"velocity_rpm": 3000.0, "acceleration_rpm_per_s": 1e6}
"""Largest limits that a run's document has."""
LEAST_S = 2e-6
"""Least duration of a row."""
PART_CHARACTERS = 900_000
"""Maximum length of a run's rows: it is a run, and a message of the page, with what stands around them."""
STEP_CHARACTERS = 200
"""Room for a step beside the rows."""
NAME_CHARACTERS = 24
"""Length of a machine's name in that of a run, which has 32 with its numbers."""


@dataclass
class BenchRun:
    """Run of a part of a program. ``timeline``: times of its plan in seconds at which lines of the program
    begin. ``pause``: what the machine waits for after it, or None at the end."""

    text: str
    duration_s: float
    timeline: list[tuple[float, int]]
    pause: Pause | None


@dataclass
class _Part:
    """Steps of a run that is being made."""

    steps: list[dict[str, object]] = field(default_factory=list)
    rows: list[str] = field(default_factory=list)
    row_count: int = 0
    row_characters: int = 0
    at_s: float = 0.0
    timeline: list[tuple[float, int]] = field(default_factory=list)

    @property
    def characters(self) -> int:
        """Length of its text, about."""
        return self.row_characters + STEP_CHARACTERS * len(self.steps)

    def begin(self, place: TextPlace) -> None:
        """Note that a line of the program begins."""
        if not self.timeline or self.timeline[-1][1] != place.line:
            self.timeline.append((round(self.at_s, 4), place.line))


class BenchRuns:
    """Makes runs of a plan without problems for the axes of a bench. Problems and remarks of the bench's side
    stand in ``problems`` and ``remarks``."""

    def __init__(self, plan: PathPlan, axes: Mapping[str, AxisNow]) -> None:
        self._plan, self._machine, self._axes = plan, plan.machine, axes
        self._followers = {name for name, axis in axes.items() if axis.follows_paths}
        self.problems: list[Problem] = []
        self.remarks: list[Problem] = []
        self._said: set[str] = set()
        self.runs = list(self._runs())
        if self.runs:
            self.runs[-1].pause = None  # nothing is left to be done after it

    def _runs(self) -> Iterator[BenchRun]:
        parts: list[tuple[_Part, Pause | None]] = []
        part = _Part()
        for item in self._plan.items:
            if isinstance(item, PlannedStretch):
                for fits in self._that_fit(item):
                    if part.characters + _characters(fits) > PART_CHARACTERS and part.characters:
                        parts.append((part, None))
                        part = _Part()
                    self._stretch(part, fits)
            elif isinstance(item, Dwell):
                self._path(part)
                part.begin(item.place)
                part.steps.append({"dwell_s": item.seconds})
                part.at_s += item.seconds
            elif isinstance(item, Switch):
                self._switch(part, item)
            elif isinstance(item, Pause):
                parts.append((part, item))
                part = _Part()
        if part.steps or part.rows:
            parts.append((part, None))
        for number, (each, pause) in enumerate(parts, 1):
            yield self._run(each, pause, self._name(number if len(parts) > 1 or pause else 0))

    def _that_fit(self, item: PlannedStretch) -> Iterator[PlannedStretch]:
        """Cut a stretch that no run has room for: the machine stands between its parts."""
        count = -(-_characters(item) // PART_CHARACTERS)
        if count <= 1:
            yield item
            return
        chords, here = item.stretch.chords, item.stretch.begin
        size = -(-len(chords) // count)
        for first in range(0, len(chords), size):
            some = chords[first : first + size]
            if first:
                what = "the machine stands here, and goes on"
                self._remark(some[0].place, what, "a run has no room for more; a larger tolerance helps")
            yield planned(replace(item.stretch, begin=here, chords=some), self._machine, item.override)
            here = some[-1].end

    def _name(self, number: int) -> str:
        """Name of a part's run; 0: of the only one."""
        return f"{self._machine.name[:NAME_CHARACTERS]}_{number}" if number else self._machine.name

    def _run(self, part: _Part, pause: Pause | None, name: str) -> BenchRun:
        self._path(part)
        if len(part.steps) > STEPS:
            self._too_long(f"{len(part.steps)} steps; a run has at most {STEPS}")
        axes = {name: _rules(axis, self._axes[name]) for name, axis in _named(self._machine)}
        for switch in _pins(self._machine):
            axes.setdefault(switch.rpartition(".")[0], {})
        steps = part.steps or [{"dwell_s": 0.0}]
        document = {"run": name, "axes": axes, "profile": "trapezoid", "steps": steps}
        text = json.dumps(document, separators=(",", ":"))
        if len(text) > DOCUMENT_BYTES or part.row_count > ROWS:
            self._too_long(f"{part.row_count} pieces make {len(text)} characters")
        return BenchRun(text, part.at_s, part.timeline, pause)

    def _too_long(self, what: str) -> None:
        remedy = f"a run has at most {DOCUMENT_BYTES}: allow a larger tolerance, or add a pause (M0)"
        self.problems.append(Problem(self._plan.file, 0, 0, f"the path is too long: {what}", remedy))

    # ---- motions ----

    def _stretch(self, part: _Part, item: PlannedStretch) -> None:
        """Add a stretch: as rows of a path, or from end to end where an axis makes ramps of its own."""
        alone = {n for n, axis in enumerate(self._machine.axes) if axis.bench_axis not in self._followers}
        stretch = item.stretch
        if not any(chord.way[n] for chord in stretch.chords for n in alone):
            self._rows(part, stretch.begin, stretch.chords, self._speeds(item))
            return
        here, along = stretch.begin, list[Chord]()
        for chord in stretch.chords:
            if not any(chord.way[n] for n in alone):
                along.append(chord)
                continue
            here = self._along(part, item, here, along)
            along = []
            self._ramped(part, chord)
            here = chord.end
        self._along(part, item, here, along)

    def _speeds(self, item: PlannedStretch) -> Sequence[ChordSpeed]:
        """Speeds of a stretch; with a stop after each chord where that is quicker."""
        if item.is_streamed or len(item.speeds) == 1:
            return item.speeds
        stretch = item.stretch
        alone = (replace(stretch, chords=[chord]) for chord in stretch.chords)
        axes, segment_s = self._machine.axes, self._machine.segment_s
        return [stretch_speeds(each, axes, segment_s, item.override)[0] for each in alone]

    def _along(self, part: _Part, item: PlannedStretch, here: Position, chords: Sequence[Chord]) -> Position:
        """Add chords between two that stop, with speeds of their own; answers their end."""
        if not chords:
            return here
        own = planned(replace(item.stretch, begin=here, chords=chords), self._machine, item.override)
        self._rows(part, here, chords, self._speeds(own))
        return chords[-1].end

    def _rows(
        self, part: _Part, begin: Position, chords: Sequence[Chord], speeds: Sequence[ChordSpeed]
    ) -> None:
        here = begin
        for chord, speed in zip(chords, speeds, strict=True):
            part.begin(chord.place)
            done = 0.0
            phases = _phases(speed)
            for number, (lasts_s, first, last) in enumerate(phases, 1):
                done += lasts_s * (first + last) / 2
                share = 1.0 if number == len(phases) else min(done / chord.length, 1.0)
                place = [a + share * way for a, way in zip(here, chord.way, strict=True)]
                self._row(part, lasts_s, 2 * first / (first + last), place)
            here = chord.end

    def _row(self, part: _Part, lasts_s: float, begin: float, place: Sequence[float]) -> None:
        angles = (
            f"{axis.motor_deg(at):.6f}"
            for axis, at in zip(self._machine.axes, place, strict=True)
            if axis.bench_axis in self._followers
        )
        row = f"{lasts_s:.9f} {begin:.7g} {' '.join(angles)}"
        part.rows.append(row)
        part.row_count += 1
        part.row_characters += len(row) + 2
        part.at_s += lasts_s

    def _path(self, part: _Part) -> None:
        """End the path that the rows are of."""
        if not part.rows:
            return
        axes = [axis.bench_axis for axis in self._machine.axes if axis.bench_axis in self._followers]
        corner_s = min(self._machine.segment_s * SPARE, 1.0)
        part.steps.append({"path": {"axes": axes, "rows": "\n".join(part.rows), "corner_s": corner_s}})
        part.rows = []

    def _ramped(self, part: _Part, chord: Chord) -> None:
        """Add a chord by moves that begin together, as axes with ramps of their own make them."""
        self._path(part)
        part.begin(chord.place)
        limit = limits_of(chord, self._machine.axes)
        acceleration = limit.acceleration_per_s2
        speed = min(chord.asked_per_s, limit.speed_per_s, sqrt(acceleration * chord.length))
        lasts_s = chord.length / speed + speed / acceleration
        moves = zip(self._machine.axes, chord.way, chord.end, strict=True)
        targets = {axis.bench_axis: round(axis.motor_deg(end), 6) for axis, way, end in moves if way}
        part.steps.append({"move": targets, "in_s": round(lasts_s * SPARE, 6)})
        part.at_s += lasts_s * SPARE
        for axis, way in zip(self._machine.axes, chord.way, strict=True):
            if way and axis.bench_axis not in self._followers:
                name = axis.letter.upper()
                what = f"{name} is moved by ramps of its board, {axis.bench_axis}"
                self._remark(chord.place, what, "the machine stops at the ends of its pieces")

    # ---- switches ----

    def _switch(self, part: _Part, item: Switch) -> None:
        self._path(part)
        part.begin(item.place)
        switch = getattr(self._machine.text.switches, item.name)
        if switch is None:
            return
        if switch.pin is None:
            what = f"a node of the line switches {item.name}, which runs do not reach"
            self._remark(item.place, what, f"nothing is switched; add a pin: to switches.{item.name}")
            return
        is_on = item.state != "off"
        part.steps.append({"pins": {switch.pin: switch.level if is_on else 1 - switch.level}})

    def _remark(self, place: TextPlace, what: str, remedy: str) -> None:
        if what not in self._said:
            self._said.add(what)
            self.remarks.append(Problem(self._plan.file, *place, what, remedy))


def _characters(item: PlannedStretch) -> int:
    """Length of a stretch's rows at the most, with angles of six digits."""
    chords = len(item.stretch.chords)
    rows = sum(len(_phases(speed)) for speed in item.speeds) if item.is_streamed else 3 * chords
    return rows * (24 + 14 * len(item.stretch.begin))


def machine_problems(machine: Machine, file: str, known: Mapping[str, AxisNow]) -> list[Problem]:
    """Problems of a machine on a bench with these axes."""
    problems = []
    there = ", ".join(known) or "none"
    for axis in machine.axes:
        letter = axis.letter.upper()
        if axis.bench_axis is None:
            what = f"no axis of the bench moves {letter}"
            problems.append(Problem(file, 0, 0, what, f"add axis: to axes.{axis.letter}; there are {there}"))
        elif axis.bench_axis not in known:
            what = f"the bench has no axis {axis.bench_axis}, which is to move {letter}"
            problems.append(Problem(file, 0, 0, what, f"there are {there}"))
        else:
            problems += _beyond(axis, file, known[axis.bench_axis])
    return problems


def _beyond(axis: MachineAxis, file: str, now: AxisNow) -> Iterator[Problem]:
    """Find the limits of a machine's axis that its board does not take."""
    for key, asked in _limits(axis).items():
        if (bound := now.bounds.get(key)) and not bound.minimum <= round(asked, 6) <= bound.maximum:
            takes = f"{plain(bound.minimum)} to {plain(bound.maximum)} {LIMITS[key]}"
            what = (
                f"{axis.letter.upper()} is to have {asked:.4g} {LIMITS[key]}; {axis.bench_axis} takes {takes}"
            )
            yield Problem(file, 0, 0, what, f"change the limits of axes.{axis.letter}")


def _named(machine: Machine) -> Iterator[tuple[str, MachineAxis]]:
    return ((str(axis.bench_axis), axis) for axis in machine.axes)


def _limits(axis: MachineAxis) -> dict[str, float]:
    """Limits of the motor of a machine's axis, by their names in runs."""
    scale = abs(axis.motor_deg_per_unit) / DEG_PER_S
    return {
        "velocity_rpm": axis.speed_per_s * scale,
        "acceleration_rpm_per_s": axis.acceleration_per_s2 * scale,
    }


def _pins(machine: Machine) -> Iterator[str]:
    switches = machine.text.switches
    for switch in (switches.spindle, switches.mist, switches.flood):
        if switch is not None and switch.pin is not None:
            yield switch.pin


def _rules(axis: MachineAxis, now: AxisNow) -> dict[str, float]:
    """Limits of an axis in a run, all within what its board takes."""
    most = {key: bound.maximum for key, bound in now.bounds.items()}
    ends = sorted((axis.motor_deg(axis.minimum), axis.motor_deg(axis.maximum)))
    return {
        **{
            key: min(limit * SPARE, MOST_IN_RUNS[key], most.get(key, limit * SPARE))
            for key, limit in _limits(axis).items()
        },
        "min_deg": max(ends[0] - 0.01, -1e6),
        "max_deg": min(ends[1] + 0.01, 1e6),
    }


def _phases(speed: ChordSpeed) -> list[tuple[float, float, float]]:
    """Parts of a chord with one acceleration each: duration, speeds at both ends. Tiny ones are left out."""
    begin, most, end = speed.begin_per_s, speed.most_per_s, speed.end_per_s
    parts = [(speed.up_s, begin, most), (speed.cruise_s, most, most), (speed.down_s, most, end)]
    kept = [part for part in parts if part[0] >= LEAST_S and part[1] + part[2] > 0]
    return kept or [(max(speed.duration_s, LEAST_S), most, most)]
