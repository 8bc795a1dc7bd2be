"""Runs that are slowed down and paused: they stay on their paths."""

import re
from functools import cache
from itertools import pairwise
from math import cos, hypot, pi, sin
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.firmware.set_point_paths import at, rest_of
from hil.runs import Execution, Plan, plan_run, run_from_data
from hil.runs.course import BACK_NS, PhraseCourse
from hil.testing import Bench
from hil.vocab.axis import AxisNow
from hil.vocab.verbs import VerbRefused

RADIUS_DEG, SPEED_DEG_PER_S, CHORDS = 30.0, 30.0, 720
AXES = {name: {"velocity_rpm": 20.0, "acceleration_rpm_per_s": 300.0} for name in ("m1", "m2")}


def circle(chords: int = CHORDS) -> dict[str, Any]:
    """Run from rest to a circle around the axes' zero, along it, and to rest."""
    each_s = 2 * pi * RADIUS_DEG / SPEED_DEG_PER_S / chords
    angles = [2 * pi * number / chords for number in range(1, chords + 1)]
    rows = [f"0.2 0 {RADIUS_DEG} 0"]
    rows += [f"{each_s:.9f} 1 {RADIUS_DEG * cos(a):.9f} {RADIUS_DEG * sin(a):.9f}" for a in angles]
    rows.append(f"0.2 2 {RADIUS_DEG} 3")
    path = {"axes": ["m1", "m2"], "rows": "\n".join(rows), "corner_s": 0.05}
    return {
        "run": "circle",
        "axes": AXES,
        "steps": [{"move": {"m1": RADIUS_DEG, "m2": -3.0}}, {"path": path}],
    }


@cache
def circle_plan() -> Plan:
    axes = {name: AxisNow(place, True) for name, place in (("m1", RADIUS_DEG), ("m2", -3.0))}
    return plan_run(*run_from_data(circle(180)), axes)


def test_a_run_is_paused_and_slowed_on_its_path() -> None:
    servo = {"profile": "mechaduino", "flash": {"table": "identity"}}
    made = Bench({"bench": "runs", "devices": {"m1": servo, "m2": servo}})
    made.run(4100)
    for name in AXES:
        made.axis(name).do("enable")
    made.run(100)
    execution = made.execute(circle())
    recordings = [made.axis(name).record("r", interval_ms=1) for name in AXES]
    paces, seen = iter([(3.0, 0.0), (4.0, 0.5), (5.0, 1.0)]), []
    change, begun_ns = next(paces), made.now_ns
    for until_ns in execution.run():
        made.run_until(until_ns / 1e6)
        seen.append((execution.progress.gone_ns, execution.progress.planned_end_ns))
        if change and made.now_ns - begun_ns > change[0] * 1e9:
            execution.set_pace(change[1])
            change = next(paces, None)
    assert execution.progress.state == "done"
    assert execution.progress.why is None
    places = [(x, y) for (_, x), (_, y) in zip(recordings[0].rows, recordings[1].rows, strict=True)]
    first = next(number for number, (x, y) in enumerate(places) if abs(x - RADIUS_DEG) < 1e-4 and y > 0)
    on_path = [place for place in places[first:] if abs(place[0] - RADIUS_DEG) > 1e-3 or place[1] < 0]
    chord_deg = RADIUS_DEG * (1 - cos(pi / CHORDS))
    off_deg = max(abs(hypot(x, y) - RADIUS_DEG) for x, y in on_path)
    assert chord_deg / 2 < off_deg < chord_deg + 2e-5
    speeds = [hypot(b[0] - a[0], b[1] - a[1]) / 1e-3 for a, b in pairwise(places[first:])]
    assert 700 < sum(speed == 0 for speed in speeds) < 1000  # a second, without its ramps
    assert max(speeds) < SPEED_DEG_PER_S * 1.2  # control steps are 0.15 ms apart
    changes = [
        abs(b - a) / 1e-3
        for a, b in pairwise([sum(speeds[n : n + 5]) / 5 for n in range(0, len(speeds) - 5)])
    ]
    assert max(changes) < 2 * 300 * 6
    gone = [gone_ns for gone_ns, _ in seen]
    assert gone == sorted(gone)
    assert execution.progress.gone_ns == execution.progress.planned_ns
    assert None in [end_ns for _, end_ns in seen]  # while it is paused nobody knows


@settings(max_examples=40)
@given(
    st.lists(st.tuples(st.integers(0, 1_500_000_000), st.sampled_from((0.0, 0.1, 0.37, 1.0))), max_size=6),
    st.sampled_from((0.2, 1.0)),
)
def test_whatever_the_pace_the_paths_are_kept(changes: Any, first_pace: float) -> None:
    """What the axes are given, at each time, is what the plan has at the time that the course tells."""
    phrase = circle_plan().phrases[1]
    course = PhraseCourse(phrase, 1_000_000_000, circle_plan().run.axes, first_pace, True)
    given, since_ns, now_ns = dict(course.first_paths()), 1_000_000_000, 1_000_000_000
    for wait_ns, pace in [*changes, (0, 1.0)]:
        now_ns += BACK_NS + wait_ns
        if not course.is_steady(now_ns):
            continue
        if course.change(pace, now_ns, 30_000_000) or course.wants_more(now_ns):
            since_ns, given = course.paths(now_ns)
        for at_ns in range(now_ns, now_ns + 400_000_000, 37_777_777):
            for name, path in given.items():
                wanted = at(phrase.paths[name], course.plan_ns(at_ns))[0]
                assert at(path, at_ns - since_ns)[0] == pytest.approx(wanted, abs=2e-3)
    if (end_ns := course.end_ns()) is not None:
        assert course.plan_ns(end_ns) == phrase.duration_ns
        assert course.plan_ns(end_ns - 40) < phrase.duration_ns or course.pace == 0


def test_long_paths_are_given_in_parts() -> None:
    data = circle(chords=9000)
    axes = {name: AxisNow(place, True) for name, place in (("m1", RADIUS_DEG), ("m2", -3.0))}
    plan = plan_run(*run_from_data(data), axes)
    phrase = plan.phrases[1]
    course = PhraseCourse(phrase, 0, plan.run.axes, 1.0, True)
    given, since_ns, parts = dict(course.first_paths()), 0, 1
    assert len(given["m1"]) < 3000 < len(phrase.paths["m1"])
    for now_ns in range(0, phrase.duration_ns + 20_000_000, 10_000_000):
        if course.wants_more(now_ns):
            since_ns, given = course.paths(now_ns)
            parts += 1
        for name, path in given.items():
            wanted = at(phrase.paths[name], now_ns)[0]
            assert at(path, now_ns - since_ns)[0] == pytest.approx(wanted, abs=1e-9)
    assert parts >= 3
    whole = PhraseCourse(phrase, 0, plan.run.axes, 1.0, False).first_paths()  # a board that joins no path
    assert whole["m1"] == phrase.paths["m1"]


@given(st.integers(0, 10_000_000_000))
def test_the_rest_of_a_path_goes_on_where_it_was(into_ns: int) -> None:
    path = circle_plan().phrases[1].paths["m2"]
    rest = rest_of(path, into_ns)
    for later_ns in (0, 1, 5_000_000, 3_000_000_000):
        assert at(rest, later_ns) == pytest.approx(at(path, into_ns + later_ns), abs=1e-6)


def test_a_run_with_a_real_board_keeps_its_pace() -> None:
    axes = {"m1": AxisNow(RADIUS_DEG, True, tells_position=False), "m2": AxisNow(-3.0, True)}
    plan = plan_run(*run_from_data(circle(90)), axes)
    execution = Execution(plan, None, None)  # type: ignore[arg-type]  # it does not begin
    with pytest.raises(VerbRefused, match="m1: a real board's path stays as it is"):
        execution.set_pace(0)


def test_a_controlled_stop_stays_on_the_path() -> None:
    servo = {"profile": "mechaduino", "flash": {"table": "identity"}}
    made = Bench({"bench": "runs", "devices": {"m1": servo, "m2": servo}})
    made.run(4100)
    for name in AXES:
        made.axis(name).do("enable")
    made.run(100)
    execution, stopped_ns = made.execute(circle()), 0
    for until_ns in execution.run():
        made.run_until(until_ns / 1e6)
        if execution.progress.gone_ns > 3_000_000_000 and not stopped_ns:
            execution.stop("grace")
            stopped_ns = made.now_ns
    assert execution.progress.state == "cancelled"
    x, y = (made.axis(name).snapshot().r for name in AXES)
    assert hypot(x, y) == pytest.approx(RADIUS_DEG, abs=2e-3)
    assert 50_000_000 < made.now_ns - stopped_ns < 500_000_000
    assert all(report.at_end == "stands" for report in execution.progress.axes.values())


def test_on_a_computer_that_is_late_the_axes_do_not_jump(monkeypatch: pytest.MonkeyPatch) -> None:
    servo = {"profile": "mechaduino", "flash": {"table": "identity"}}
    made = Bench({"bench": "runs", "devices": {"m1": servo, "m2": servo}})
    made.run(4100)
    for name in AXES:
        made.axis(name).do("enable")
    made.run(100)
    late = [200, 100]
    paths = PhraseCourse.paths

    def made_late(course: PhraseCourse, now_ns: int) -> Any:
        made.run(late.pop() if late else 0)
        return paths(course, now_ns)

    monkeypatch.setattr(PhraseCourse, "paths", made_late)
    execution, asked = made.execute(circle()), False
    recordings = [made.axis(name).record("r", interval_ms=1) for name in AXES]
    for until_ns in execution.run():
        made.run_until(max(until_ns, made.now_ns) / 1e6)
        if execution.progress.gone_ns > 3_000_000_000 and not asked:
            execution.set_pace(0)
            asked = True
        if asked and made.now_ns > 8_000_000_000:
            execution.set_pace(1)
    assert execution.progress.state == "done", execution.progress.why
    assert not late
    places = list(zip(*(recording.rows for recording in recordings), strict=True))[1000:]
    speeds = [hypot(b[0][1] - a[0][1], b[1][1] - a[1][1]) / 1e-3 for a, b in pairwise(places)]
    assert max(speeds) < SPEED_DEG_PER_S * 1.2


def test_axes_that_came_to_the_end_of_what_they_were_given_are_said_to_be_late() -> None:
    servo = {"profile": "mechaduino", "flash": {"table": "identity"}}
    made = Bench({"bench": "runs", "devices": {"m1": servo, "m2": servo}})
    made.run(4100)
    for name in AXES:
        made.axis(name).do("enable")
    made.run(100)
    execution, was_busy = made.execute(circle(chords=9000)), False
    for until_ns in execution.run():
        made.run_until(max(until_ns, made.now_ns) / 1e6)
        if execution.progress.gone_ns > 1_500_000_000 and not was_busy:
            was_busy = True
            made.run(4000)  # the program that gives the pieces has no CPU for so long
    assert execution.progress.state == "failed"
    assert re.fullmatch(r"this computer was too busy: more of .* was due \d+ ms ago", execution.progress.why)
