"""The whole motion of a run, made before anything moves: phrases that go by the clock, waits in between."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from itertools import pairwise
from math import ceil
from struct import Struct
from typing import Any

from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import suggestion
from hil.core.trajectory import (
    AxisLimits,
    AxisState,
    PlanError,
    PlanProblem,
    Trajectory,
    plan_joint,
    plan_line,
    plan_spline,
    plan_spline_within,
)
from hil.runs.axes import AxisNow
from hil.runs.document import STEPS, RunDocument, Step, WaitUntil
from hil.vocab.path import DEG_PER_S, PathPiece
from hil.vocab.time import NS_PER_S

_PIECE = Struct("<q4d")
SPLINE_LOOKS = 1000
"""Times at which a spline's positions are compared with the axes' ranges."""


@dataclass(frozen=True)
class Event:
    """A verb that is carried out ``at_ns`` after its phrase's start."""

    at_ns: int
    axis: str
    verb: str
    parameters: Mapping[str, float | str]


@dataclass(frozen=True)
class Phrase:
    """What goes by the clock from one common start. ``paths``: of servos, from the start to
    ``duration_ns``. ``marks``: when which step begins. After it the ``steppers`` have to stand (and real
    servos to have confirmed their last set-point), and what ``wait`` says has to be."""

    duration_ns: int
    paths: Mapping[str, tuple[PathPiece, ...]]
    events: tuple[Event, ...]
    marks: tuple[tuple[int, int], ...]
    steppers: frozenset[str] = frozenset()
    wait: WaitUntil | None = None


@dataclass(frozen=True)
class Plan:
    """A run that can be done. ``steps``: how many, repetitions counted."""

    run: RunDocument
    phrases: tuple[Phrase, ...]
    steps: int
    ends_deg: Mapping[str, float]
    axes: Mapping[str, AxisNow]

    def digest(self) -> str:
        """The same for the same motion, to the bit."""
        total = sha256()
        for phrase in self.phrases:
            timing = (phrase.duration_ns, phrase.marks, sorted(phrase.steppers), phrase.wait)
            total.update(repr((timing, phrase.events)).encode())
            for axis, path in phrase.paths.items():
                total.update(axis.encode())
                for piece in path:
                    total.update(
                        _PIECE.pack(piece.duration_ns, piece.r, piece.per_s, piece.per_s2, piece.per_s3)
                    )
        return total.hexdigest()


def plan_run(run: RunDocument, document: Document, axes: Mapping[str, AxisNow]) -> Plan:
    """All of a run, from where its axes are.

    Raises:
        ConfigError: it cannot be done as it is; with all problems and their places.
    """
    findings = list(_axis_findings(run, axes))
    if findings:
        raise document.error(findings)
    planner = _Planner(run, axes)
    order = list(_unrolled(run.steps, planner.findings))
    for index in order if not planner.findings else ():
        planner.step(index, run.steps[index])
    planner.end_phrase()
    if planner.findings:
        raise document.error(planner.findings)
    return Plan(run, tuple(planner.phrases), len(order), planner.position_deg, axes)


def _axis_findings(run: RunDocument, axes: Mapping[str, AxisNow]) -> Iterator[Finding]:
    for name in run.axes:
        path: KeyPath = ("axes", name)
        if name not in axes:
            yield Finding(path, f"there is no device {name!r}", suggestion(name, axes), at_key=True)
        elif why := axes[name].why_not:
            yield Finding(path, why, "leave it out, or wait", at_key=True)
        elif axes[name].is_real and run.axes[name].following_error_deg is not None:
            why = f"{name} is a real board, whose terminal tells no position while it moves"
            yield Finding((*path, "following_error_deg"), why, "leave it out")
        if (rules := run.axes[name]).min_deg > rules.max_deg:
            yield Finding((*path, "min_deg"), "it is more than max_deg", "exchange them")


def _unrolled(steps: Sequence[Step], findings: list[Finding]) -> Iterator[int]:
    """Indices of steps in the order in which they are done."""
    labels: dict[str, int] = {}
    budget = [STEPS]

    def walk(start: int, end: int) -> Iterator[int]:
        for index in range(start, end):
            step = steps[index]
            if step.label:
                labels[step.label] = index
            if step.repeat is None:
                if budget[0] <= 0:
                    return
                budget[0] -= 1
                yield index
                continue
            if step.repeat.label not in labels:
                place = ("steps", index, "repeat", "label")
                known = suggestion(step.repeat.label, labels) if labels else "label a step before it"
                findings.append(Finding(place, f"no step before has the label {step.repeat.label!r}", known))
                return
            for _ in range(step.repeat.times):
                if budget[0] <= 0:
                    break
                yield from walk(labels[step.repeat.label], index)

    yield from walk(0, len(steps))
    if budget[0] <= 0 and not findings:
        findings.append(Finding(("steps",), f"these are {STEPS} steps or more, with repetitions", "do less"))


@dataclass
class _Planner:
    run: RunDocument
    axes: Mapping[str, AxisNow]
    findings: list[Finding] = field(default_factory=list)
    phrases: list[Phrase] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.position_deg = {name: self.axes[name].position_deg for name in self.run.axes}
        self._servos = [name for name in self.run.axes if self.axes[name].kind == "servo"]
        self._said: set[KeyPath] = set()
        self._begin()

    def _begin(self) -> None:
        self._at_ns = 0
        self._pieces: dict[str, list[PathPiece]] = {name: [] for name in self._servos}
        self._events: list[Event] = []
        self._marks: list[tuple[int, int]] = []
        self._steppers: set[str] = set()

    def end_phrase(self, wait: WaitUntil | None = None) -> None:
        """What was planned so far goes by one clock."""
        if self._marks or wait:
            paths = {
                name: (*pieces, PathPiece(0, self.position_deg[name]))
                for name, pieces in self._pieces.items()
                if any(piece.per_s or piece.per_s2 or piece.per_s3 for piece in pieces)
            }
            real = {name for name in paths if self.axes[name].is_real}
            events = tuple(sorted(self._events, key=lambda event: event.at_ns))
            self.phrases.append(
                Phrase(self._at_ns, paths, events, tuple(self._marks), frozenset(self._steppers | real), wait)
            )
        self._begin()

    def step(self, index: int, step: Step) -> None:
        self._marks.append((self._at_ns, index))
        path: KeyPath = ("steps", index)
        if targets := step.move or step.line:
            self._motion(path, step, dict(targets))
        elif by := step.move_by or step.line_by:
            known = {name: self.position_deg.get(name, 0.0) + angle for name, angle in by.items()}
            self._motion(path, step, known)
        elif step.spline is not None:
            self._spline(path, step)
        elif step.dwell_s is not None:
            self._hold(round(step.dwell_s * NS_PER_S))
        elif step.wait_until is not None:
            self._wait(path, step.wait_until)
        elif step.pins is not None:
            self._pins(path, step.pins)

    # ---- motions ----

    def _motion(self, path: KeyPath, step: Step, targets_deg: dict[str, float]) -> None:
        kind = next(name for name in ("move", "move_by", "line", "line_by") if getattr(step, name))
        is_line = kind.startswith("line")
        if not self._known((*path, kind), targets_deg, is_line):
            return
        servos = [name for name in targets_deg if name in self._pieces]
        steppers = [name for name in targets_deg if name not in self._pieces]
        duration_ns = None if step.in_s is None else round(step.in_s * NS_PER_S)
        planned_ns = duration_ns or 0
        if servos:
            plan = self._planned(path, kind, servos, targets_deg, duration_ns, is_line)
            if plan is None:
                return
            self._append(servos, plan)
            planned_ns = plan.duration_ns
        self._turn_steppers(path, kind, steppers, targets_deg, planned_ns, duration_ns is not None)
        self._at_ns += planned_ns
        for name in self._servos:
            if name not in servos:
                self._stand(name, planned_ns)
        self.position_deg |= targets_deg
        if steppers:
            self.end_phrase()

    def _planned(
        self,
        path: KeyPath,
        kind: str,
        servos: Sequence[str],
        targets_deg: Mapping[str, float],
        duration_ns: int | None,
        is_line: bool,
    ) -> Trajectory | None:
        here = [self.position_deg[name] for name in servos]
        there = [targets_deg[name] for name in servos]
        limits = [self._limits(name) for name in servos]
        try:
            if is_line:
                return plan_line(here, there, limits, self.run.profile, duration_ns)
            return plan_joint([AxisState(p) for p in here], there, limits, self.run.profile, duration_ns)
        except PlanError as error:
            if error.problem is PlanProblem.TOO_SHORT and error.least_ns is not None:
                least_s = ceil(error.least_ns / 1e6) / 1e3
                self._find((*path, "in_s"), "it cannot be done so quickly", f"write {least_s:g} or more")
            else:
                name = servos[error.axis] if error.axis is not None else ", ".join(servos)
                self._find((*path, kind), f"{name}: {error.what}", "see the limits of the axes")
            return None

    def _turn_steppers(
        self,
        path: KeyPath,
        kind: str,
        steppers: Sequence[str],
        targets_deg: Mapping[str, float],
        planned_ns: int,
        is_given: bool,
    ) -> None:
        """They make ramps of their own: from the common start, at a speed that takes about as long."""
        for name in steppers:
            rules = self.run.axes[name]
            angle_deg = abs(targets_deg[name] - self.position_deg[name])
            rpm = rules.velocity_rpm
            if planned_ns:
                wanted_rpm = ceil(angle_deg / (planned_ns / NS_PER_S) / DEG_PER_S)
                if is_given and wanted_rpm > rules.velocity_rpm:
                    least_s = angle_deg / (rules.velocity_rpm * DEG_PER_S)
                    remedy = f"write {ceil(least_s * 1e3) / 1e3:g} or more"
                    self._find((*path, "in_s"), f"{name} cannot be so quick", remedy)
                rpm = min(rpm, wanted_rpm)
            parameters = {"position_deg": targets_deg[name], "velocity_rpm": max(int(rpm), 1)}
            self._events.append(Event(self._at_ns, name, "move_abs", parameters))
            self._steppers.add(name)

    def _spline(self, path: KeyPath, step: Step) -> None:
        points = step.spline or []
        names = list(points[0].positions_deg)
        place = (*path, "spline")
        for number, point in enumerate(points):
            wrong = {n: v for n, v in point.positions_deg.items() if isinstance(v, bool) or not _is_angle(v)}
            if wrong:
                self._find(
                    (*place, number), f"{', '.join(wrong)}: angles are wanted", "write numbers in degrees"
                )
                return
            if set(point.positions_deg) != set(names) or not names:
                self._find((*place, number), "all points have the same axes", f"write {', '.join(names)}")
                return
            if not self._known((*place, number), point.positions_deg, True):
                return
        timed = [point.at_s is not None for point in points]
        if any(timed) != all(timed):
            self._find(place, "some points have at_s and others not", "give it to all, or to none")
            return
        rows = [[self.position_deg[name] for name in names]]
        rows += [[float(point.positions_deg[name]) for name in names] for point in points]
        limits = [self._limits(name) for name in names]
        try:
            if timed[0]:
                times_ns = [0, *(round((point.at_s or 0.0) * NS_PER_S) for point in points)]
                plan = plan_spline(rows, times_ns)
                if violation := plan.violation(limits):
                    what = f"{names[violation.axis]}: {violation.quantity} of {violation.value:.4g}"
                    when = f"at {violation.at_ns / 1e9:.3f} s; the limit is {violation.limit:.4g}"
                    self._find(place, f"{what} {when} (deg and s)", "take more time, or leave at_s out")
                    return
            else:
                plan = plan_spline_within(rows, limits)
        except PlanError as error:
            which = names[error.axis] + ": " if error.axis is not None else ""
            self._find(place, f"{which}{error.what}", "see the points and their times")
            return
        looks = plan.positions_deg(0, max(plan.duration_ns // SPLINE_LOOKS, 1), SPLINE_LOOKS + 1)
        for number, name in enumerate(names):
            rules, way = self.run.axes[name], looks[number :: len(names)]
            if min(way) < rules.min_deg or max(way) > rules.max_deg:
                said = f"{name} would go from {min(way):.4g} to {max(way):.4g} deg between the points"
                self._find(place, said, f"its range is {rules.min_deg:g} to {rules.max_deg:g}")
                return
        self._append(names, plan)
        self._at_ns += plan.duration_ns
        for name in self._servos:
            if name not in names:
                self._stand(name, plan.duration_ns)
        self.position_deg |= {name: rows[-1][number] for number, name in enumerate(names)}

    def _known(self, path: KeyPath, targets_deg: Mapping[str, Any], needs_path: bool) -> bool:
        """Whether these axes may go there."""
        before = len(self.findings)
        for name, target_deg in targets_deg.items():
            place = (*path, name)
            if name not in self.run.axes:
                self._find(place, f"{name!r} is none of the run's axes", suggestion(name, self.run.axes))
                continue
            rules = self.run.axes[name]
            if not rules.min_deg <= target_deg <= rules.max_deg:
                remedy = f"its range is {rules.min_deg:g} to {rules.max_deg:g}"
                self._find(place, f"{name} may not go to {target_deg:g} deg", remedy)
            if needs_path and self.axes[name].kind != "servo":
                why = f"{name} makes ramps of its own, and keeps to no line or spline"
                self._find(place, why, "use move for it")
        return len(self.findings) == before

    def _append(self, names: Sequence[str], plan: Trajectory) -> None:
        for number, name in enumerate(names):
            segments = plan.segments(number)
            if not segments:
                self._stand(name, plan.duration_ns)
                continue
            starts_ns = [round(segment.start_s * NS_PER_S) for segment in segments]
            for segment, (from_ns, to_ns) in zip(
                segments, pairwise([*starts_ns, plan.duration_ns]), strict=True
            ):
                if to_ns > from_ns:
                    self._pieces[name].append(
                        PathPiece(
                            to_ns - from_ns,
                            segment.position_deg,
                            segment.velocity_deg_per_s,
                            segment.acceleration_deg_per_s2,
                            segment.jerk_deg_per_s3,
                        )
                    )

    def _hold(self, duration_ns: int) -> None:
        for name in self._servos:
            self._stand(name, duration_ns)
        self._at_ns += duration_ns

    def _stand(self, name: str, duration_ns: int) -> None:
        if duration_ns:
            self._pieces[name].append(PathPiece(duration_ns, self.position_deg[name]))

    def _wait(self, path: KeyPath, wait: WaitUntil) -> None:
        place = (*path, "wait_until")
        if wait.axis not in self.run.axes:
            self._find(
                (*place, "axis"),
                f"{wait.axis!r} is none of the run's axes",
                suggestion(wait.axis, self.run.axes),
            )
        elif wait.field not in self.axes[wait.axis].fields:
            known = self.axes[wait.axis].fields
            self._find((*place, "field"), f"{wait.axis} has no {wait.field!r}", suggestion(wait.field, known))
        elif wait.above is None and wait.below is None:
            self._find(place, "neither above nor below is said", "add one of them")
        elif wait.above is not None and wait.below is not None and wait.above > wait.below:
            self._find(place, "above is more than below: nothing is in between", "exchange them")
        self.end_phrase(wait)

    def _pins(self, path: KeyPath, pins: Mapping[str, int]) -> None:
        for which, level in pins.items():
            axis, _, pin = which.partition(".")
            place = (*path, "pins", which)
            if axis not in self.run.axes:
                self._find(place, f"{axis!r} is none of the run's axes", suggestion(axis, self.run.axes))
            elif pin not in self.axes[axis].pins:
                self._find(place, f"{axis} has no input {pin!r}", suggestion(pin, self.axes[axis].pins))
            else:
                self._events.append(Event(self._at_ns, axis, "pin", {"pin": pin, "level": level}))

    def _limits(self, name: str) -> AxisLimits:
        rules = self.run.axes[name]
        return AxisLimits(
            rules.velocity_rpm * DEG_PER_S,
            rules.acceleration_rpm_per_s * DEG_PER_S,
            rules.jerk_rpm_per_s2 * DEG_PER_S,
        )

    def _find(self, path: KeyPath, message: str, remedy: str) -> None:
        """Once, however often the step is repeated."""
        if path not in self._said:
            self._said.add(path)
            self.findings.append(Finding(path, message, remedy))


def _is_angle(value: object) -> bool:
    return isinstance(value, int | float) and abs(value) <= 1e6
