"""Planner of runs, before anything moves: each step from where the one before leaves the axes."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import ceil
from typing import Any

from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import suggestion
from hil.core.trajectory import (
    AxisLimits,
    PlanError,
    PlanProblem,
    PointState,
    Trajectory,
    plan_joint,
    plan_line,
    plan_spline,
    plan_spline_within,
)
from hil.runs.path_rows import ROWS, PathReading
from hil.runs.plan import Phrases, Plan
from hil.runs.run_axis import WHOLE_RPM, bound_findings, fitted
from hil.runs.run_document import (
    STEPS,
    AxisRules,
    RunDocument,
    SplinePoint,
    Step,
    TimedPath,
    WaitUntil,
)
from hil.vocab.address import no_input, pin_of
from hil.vocab.axis import AxisNow
from hil.vocab.parameters import plain
from hil.vocab.path import DEG_PER_S
from hil.vocab.seen_over import seen_over
from hil.vocab.time import NS_PER_S

SPLINE_LOOKS = 1000
"""Number of times at which a spline's positions are compared with the axes' ranges."""


class _Impossible(Exception):
    """Error of a step that cannot be done: a finding's path, message and remedy; none where findings are
    noted already."""


def plan_run(
    run: RunDocument, document: Document, axes: Mapping[str, AxisNow], of: Collection[str] | None = None
) -> Plan:
    """Plan all of a run, from where its axes are. ``of``: axes whose paths are wanted; None: of all.

    Raises:
        ConfigError: it cannot be done as it is; with all problems and their places.
    """
    planner, steps = planned(run, document, axes, of)
    if findings := [*axis_findings(run, axes), *planner.findings]:
        raise document.error(findings)
    return Plan(planner.run, tuple(planner.phrases.ended), steps, planner.phrases.position_deg, axes)


class Anything(tuple[str, ...]):
    """Names of a device that there is not, or not here: it has all."""

    def __contains__(self, name: object) -> bool:
        return True


UNKNOWN = AxisNow(0.0, True, Anything(), Anything())
"""Axis of which nothing is known."""


def planned(
    run: RunDocument, document: Document, axes: Mapping[str, AxisNow], of: Collection[str] | None = None
) -> tuple["StepPlanner", int]:
    """Plan the steps of a run; answers the planner, with its findings, and the number of steps."""
    known = {name: axes.get(name, UNKNOWN) for name in run.axes}
    run = fitted(run, known)
    planner = StepPlanner(run, document, known, run.axes if of is None else of)
    order = list(_unrolled(run.steps, planner.findings))
    for index in order if not planner.findings else ():
        planner.step(index, run.steps[index])
    planner.phrases.end()
    planner.findings += bound_findings(run, known)
    return planner, len(order)


def axis_findings(run: RunDocument, axes: Mapping[str, AxisNow]) -> Iterator[Finding]:
    """Find what is wrong with the axes that a run names, on a bench with these."""
    for name in run.axes:
        path: KeyPath = ("axes", name)
        if name not in axes:
            yield Finding(path, f"there is no device {name!r}", suggestion(name, axes), at_key=True)
        elif why := axes[name].why_not:
            yield Finding(path, why, axes[name].remedy, at_key=True)
        elif not axes[name].tells_position and run.axes[name].following_error_deg is not None:
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


class StepPlanner:
    """Plans the steps of a run, one after the other, and notes the mistakes in them.

    Long because each kind of step begins where the one before has ended.
    """

    def __init__(
        self, run: RunDocument, document: Document, axes: Mapping[str, AxisNow], of: Collection[str]
    ) -> None:
        self.run, self._document = run, document
        self._axes = axes
        self._limits = {name: _limits(rules) for name, rules in run.axes.items()}
        self._said: set[KeyPath] = set()
        self.strangers: set[KeyPath] = set()
        """Places of names that are none of the run's axes."""
        self._rows_left = ROWS
        self.findings: list[Finding] = []
        self.phrases = Phrases({name: axes[name] for name in run.axes}, of)

    def step(self, index: int, step: Step) -> None:
        """Plan a step, from where the one before it ends."""
        if step.path is not None:
            self.phrases.end()
        self.phrases.mark(index)
        path: KeyPath = ("steps", index)
        try:
            if targets := step.move or step.line:
                self._motion(path, step, dict(targets))
            elif by := step.move_by or step.line_by:
                here_deg = self.phrases.position_deg
                self._motion(
                    path, step, {name: here_deg.get(name, 0.0) + angle for name, angle in by.items()}
                )
            elif step.spline is not None:
                self._spline((*path, "spline"), step.spline)
            elif step.path is not None:
                self._path((*path, "path"), step.path)
            elif step.dwell_s is not None:
                self.phrases.move({}, round(step.dwell_s * NS_PER_S))
            elif step.wait_until is not None:
                self._wait((*path, "wait_until"), step.wait_until)
            elif step.pins is not None:
                self._pins((*path, "pins"), step.pins)
        except _Impossible as error:
            if error.args:
                self._find(*error.args)

    # ---- motions ----

    def _motion(self, path: KeyPath, step: Step, targets_deg: dict[str, float]) -> None:
        kind = next(name for name in ("move", "move_by", "line", "line_by") if getattr(step, name))
        is_line = kind.startswith("line")
        self._check_targets((*path, kind), targets_deg, is_line)
        followers = [name for name in targets_deg if name in self.phrases.followers]
        duration_ns = None if step.in_s is None else round(step.in_s * NS_PER_S)
        trajectory = self._trajectory(path, kind, followers, targets_deg, duration_ns) if followers else None
        planned_ns = trajectory.duration_ns if trajectory else duration_ns or 0
        for name, target_deg in targets_deg.items():
            if name not in followers:
                self._send(path, name, target_deg, planned_ns, duration_ns is not None)
        self.phrases.move(targets_deg, planned_ns, followers, trajectory)

    def _trajectory(
        self,
        path: KeyPath,
        kind: str,
        followers: Sequence[str],
        targets_deg: Mapping[str, float],
        duration_ns: int | None,
    ) -> Trajectory:
        here = [self.phrases.position_deg[name] for name in followers]
        there = [targets_deg[name] for name in followers]
        limits = [self._limits[name] for name in followers]
        try:
            if kind.startswith("line"):
                return plan_line(here, there, limits, self.run.profile, duration_ns)
            return plan_joint([PointState(p) for p in here], there, limits, self.run.profile, duration_ns)
        except PlanError as error:
            if error.problem is PlanProblem.TOO_SHORT and error.least_ns is not None:
                least_s = ceil(error.least_ns / 1e6) / 1e3
                remedy = f"write {least_s:g} or more"
                raise _Impossible((*path, "in_s"), "it cannot be done so quickly", remedy) from None
            name = followers[error.axis] if error.axis is not None else ", ".join(followers)
            what = f"{name}: {error.what}"
            raise _Impossible((*path, kind), what, "see the limits of the axes") from None

    def _send(self, path: KeyPath, name: str, target_deg: float, planned_ns: int, is_given: bool) -> None:
        """Plan a motion by an axis's own ramps, at a speed that takes about as long as the others."""
        bound = self._axes[name].bounds.get("velocity_rpm", WHOLE_RPM)
        rpm = most_rpm = max(self.run.axes[name].velocity_rpm, bound.minimum)  # less was found already
        if planned_ns:
            angle_deg = abs(target_deg - self.phrases.position_deg[name])
            wanted_rpm = angle_deg / (planned_ns / NS_PER_S) / DEG_PER_S
            wanted_rpm = ceil(wanted_rpm) if bound.is_whole else wanted_rpm
            if is_given and wanted_rpm > most_rpm:
                least_s = angle_deg / (most_rpm * DEG_PER_S)
                remedy = f"write {ceil(least_s * 1e3) / 1e3:g} or more"
                self._find((*path, "in_s"), f"{name} cannot be so quick", remedy)
            rpm = max(min(rpm, wanted_rpm), bound.minimum)
        self.phrases.send(name, target_deg, int(rpm) if bound.is_whole else rpm)

    def _spline(self, place: KeyPath, points: Sequence[SplinePoint]) -> None:
        names = list(points[0].positions_deg)
        for number, point in enumerate(points):
            self._check_point((*place, number), point, names)
        if len({point.at_s is None for point in points}) > 1:
            raise _Impossible(place, "some points have at_s and others not", "give it to all, or to none")
        rows = [[self.phrases.position_deg[name] for name in names]]
        rows += [[float(point.positions_deg[name]) for name in names] for point in points]
        try:
            trajectory = self._through(place, names, rows, [point.at_s for point in points])
        except PlanError as error:
            which = names[error.axis] + ": " if error.axis is not None else ""
            raise _Impossible(
                place,
                f"{which}{error.what}",
                "let times grow from point to point",
            ) from None
        self._check_way(place, names, trajectory)
        targets_deg = dict(zip(names, rows[-1], strict=True))
        self.phrases.move(targets_deg, trajectory.duration_ns, names, trajectory)

    def _through(
        self,
        place: KeyPath,
        names: Sequence[str],
        rows: Sequence[Sequence[float]],
        times_s: Sequence[float | None],
    ) -> Trajectory:
        """Plan a spline through rows of positions, at the times or as soon as can be. Raises PlanError."""
        limits = [self._limits[name] for name in names]
        if times_s[0] is None:
            return plan_spline_within(rows, limits)
        trajectory = plan_spline(rows, [0, *(round((at_s or 0.0) * NS_PER_S) for at_s in times_s)])
        if violation := trajectory.violation(limits):
            value = seen_over(violation.value, violation.limit)
            what = f"{names[violation.axis]}: {violation.quantity} of {value}"
            when = f"at {violation.at_ns / 1e9:.3f} s; the limit is {violation.limit:g}"
            raise _Impossible(place, f"{what} {when} (deg and s)", "take more time, or leave at_s out")
        return trajectory

    def _path(self, place: KeyPath, path: TimedPath) -> None:
        for number, name in enumerate(path.axes):
            where = (*place, "axes", number)
            if name not in self.run.axes:
                self._find(*self._no_axis(where, name))
            elif name in path.axes[:number]:
                self._find(where, f"{name} is there twice", "leave it out")
            elif not self._axes[name].follows_paths:
                self._find(where, f"{name} makes ramps of its own, and keeps to no path", "use move for it")
        if any(found.path[: len(place)] == place for found in self.findings):
            raise _Impossible
        here = [self.phrases.position_deg[name] for name in path.axes]
        reading = PathReading(path, place, self._document, here, self.run.axes)
        if reading.findings:
            if place not in self._said:
                self._said.add(place)
                self.findings += reading.findings
            raise _Impossible
        self._rows_left -= len(reading.rows)
        if self._rows_left < 0:
            what = f"the run has over {ROWS} rows up to here, repetitions counted"
            raise _Impossible((*place, "rows"), what, "repeat less, or make several runs of it")
        if reading.rows:
            pieces = dict(zip(path.axes, reading.pieces(here), strict=True))
            ends_deg = dict(zip(path.axes, reading.rows[-1].end_deg, strict=True))
            self.phrases.follow(ends_deg, sum(row.duration_ns for row in reading.rows), pieces)

    # ---- what is wrong ----

    def _check_targets(self, path: KeyPath, targets_deg: Mapping[str, Any], needs_path: bool) -> None:
        findings = []
        for name, target_deg in targets_deg.items():
            place = (*path, name)
            if (rules := self.run.axes.get(name)) is None:
                findings.append(self._no_axis(place, name))
                continue
            least_deg, most_deg = self._range_deg(name, rules)
            if not least_deg <= target_deg <= most_deg:
                shown = seen_over(target_deg, least_deg if target_deg < least_deg else most_deg)
                what = f"{name} may not go to {shown} deg"
                findings.append((place, what, _range(least_deg, most_deg)))
            if needs_path and not self._axes[name].follows_paths:
                what = f"{name} makes ramps of its own, and keeps to no line or spline"
                findings.append((place, what, "use move for it"))
        for finding in findings:
            self._find(*finding)
        if findings:
            raise _Impossible

    def _range_deg(self, name: str, rules: AxisRules) -> tuple[float, float]:
        """Range in which an axis may be sent to angles: the run's, and within it the board's."""
        bound = self._axes[name].bounds.get("position_deg")
        if bound is None:
            return rules.min_deg, rules.max_deg
        return max(rules.min_deg, bound.minimum), min(rules.max_deg, bound.maximum)

    def _check_point(self, place: KeyPath, point: SplinePoint, names: Sequence[str]) -> None:
        positions_deg = point.positions_deg
        if wrong := [name for name, angle in positions_deg.items() if not _is_angle(angle)]:
            raise _Impossible(place, f"{', '.join(wrong)}: angles are wanted", "write numbers in degrees")
        if set(positions_deg) != set(names) or not names:
            raise _Impossible(place, "all points have the same axes", f"write {', '.join(names)}")
        self._check_targets(place, positions_deg, True)

    def _check_way(self, place: KeyPath, names: Sequence[str], trajectory: Trajectory) -> None:
        """Check that a spline stays in the axes' ranges between its points."""
        every_ns = max(trajectory.duration_ns // SPLINE_LOOKS, 1)
        looks = trajectory.positions_deg(0, every_ns, SPLINE_LOOKS + 1)
        for number, name in enumerate(names):
            rules, way = self.run.axes[name], looks[number :: len(names)]
            if min(way) < rules.min_deg or max(way) > rules.max_deg:
                low, high = seen_over(min(way), rules.min_deg), seen_over(max(way), rules.max_deg)
                said = f"{name} would go from {low} to {high} deg between the points"
                raise _Impossible(place, said, _range(rules.min_deg, rules.max_deg))

    def _wait(self, place: KeyPath, wait: WaitUntil) -> None:
        self.phrases.end(wait)
        if wait.axis not in self.run.axes:
            self._find(*self._no_axis((*place, "axis"), wait.axis))
        elif wait.field not in (known := self._axes[wait.axis].fields):
            self._find((*place, "field"), f"{wait.axis} has no {wait.field!r}", suggestion(wait.field, known))
        elif wait.above is None and wait.below is None:
            self._find(place, "neither above nor below is said", "add one of them")
        elif wait.above is not None and wait.below is not None and wait.above > wait.below:
            self._find(place, "above is more than below: nothing is in between", "exchange them")

    def _pins(self, path: KeyPath, pins: Mapping[str, int]) -> None:
        for which, level in pins.items():
            axis, pin = pin_of(which)
            place = (*path, which)
            if axis not in self.run.axes:
                self._find(*self._no_axis(place, axis))
            elif pin not in self._axes[axis].pins:
                self._find(place, *no_input(axis, pin, self._axes[axis].pins))
            else:
                self.phrases.drive(axis, pin, level)

    def _no_axis(self, place: KeyPath, name: str) -> tuple[KeyPath, str, str]:
        self.strangers.add(place)
        return place, f"{name!r} is none of the run's axes", suggestion(name, self.run.axes)

    def _find(self, path: KeyPath, message: str, remedy: str) -> None:
        """Note a mistake once, however often the step is repeated."""
        if path not in self._said:
            self._said.add(path)
            self.findings.append(Finding(path, message, remedy))


def _limits(rules: AxisRules) -> AxisLimits:
    rpm = rules.velocity_rpm, rules.acceleration_rpm_per_s, rules.jerk_rpm_per_s2
    return AxisLimits(*(each * DEG_PER_S for each in rpm))


def _range(least_deg: float, most_deg: float) -> str:
    return f"its range is {plain(least_deg)} to {plain(most_deg)}"


def _is_angle(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= 1e6
