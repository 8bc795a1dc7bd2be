"""Problems of a run's text: all of them at once, on its bench or without one."""

from collections.abc import Iterator, Mapping, Sequence

from hil.config.document import Document, Finding, KeyPath
from hil.runs.path_rows import PathReading
from hil.runs.planner import UNKNOWN, StepPlanner, axis_findings, planned
from hil.runs.run_document import RunDocument, RunTextError, SplinePoint, parse_run
from hil.vocab.axis import AxisNow
from hil.vocab.problem import ConfigError

_DEPENDS = frozenset({"in_s", "move_by", "line_by", "path", "spline"})
"""Keys of a step whose problems can come from where the step before it ends."""


def all_problems(error: RunTextError, axes: Mapping[str, AxisNow]) -> ConfigError:
    """Problems of a run's text, with those of the rest of it on a bench with these axes: without those that a
    wrong step before could be the cause of."""
    if error.rest is None:
        return error
    planner, _ = planned(error.rest, error.document, axes)
    return error.document.error([*error.findings, *axis_findings(error.rest, axes), *_certain(planner)])


def checked_run(text: str, file: str) -> RunDocument:
    """Read a run's text and check what can be said of it without its bench. ``file``: name that problems
    carry.

    Raises:
        ConfigError: with all problems.
    """
    try:
        run, document = parse_run(text, file)
    except RunTextError as error:
        raise all_problems(error, dict.fromkeys(error.rest.axes, UNKNOWN) if error.rest else {}) from None
    planner, _ = planned(run, document, {})
    found = [each for each in _certain(planner) if each.path[-1] not in ("move", "line")]
    found += _of_numbers(run, document)
    if findings := [*axis_findings(run, dict.fromkeys(run.axes, UNKNOWN)), *found]:
        raise document.error(findings)
    return run


def _certain(planner: StepPlanner) -> Iterator[Finding]:
    """Problems that are there wherever the axes begin."""
    for each in planner.findings:
        if each.path in planner.strangers or _DEPENDS.isdisjoint(each.path):
            yield each


def _of_numbers(run: RunDocument, document: Document) -> Iterator[Finding]:
    """Problems of times and rows that are there wherever the axes begin."""
    for index, step in enumerate(run.steps):
        place: KeyPath = ("steps", index)
        if step.in_s == 0:
            yield Finding((*place, "in_s"), "a motion takes time", "write more than 0, or leave in_s out")
        if step.spline is not None:
            yield from _of_times((*place, "spline"), step.spline)
        if step.path is not None:
            yield from PathReading(step.path, (*place, "path"), document, None, run.axes).findings


def _of_times(place: KeyPath, points: Sequence[SplinePoint]) -> Iterator[Finding]:
    before_s = 0.0
    for number, point in enumerate(points):
        if point.at_s is None:
            continue
        if point.at_s <= before_s:
            what = f"{point.at_s:g} s is not later than {before_s:g} s, the time before"
            remedy = f"write more than {before_s:g}; times count from the spline's start"
            yield Finding((*place, number, "at_s"), what, remedy)
        before_s = max(before_s, point.at_s)
