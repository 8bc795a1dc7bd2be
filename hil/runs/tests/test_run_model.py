"""Random runs over axes of no board: whatever an axis is and whatever goes wrong with it, a run begins,
moves, ends and lets go in the one way that ``hil.vocab.axis`` says."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from model_axes import ModelAxes, ModelAxis, ModelClock, Wrong

from hil.runs import Execution, Progress, Soon, plan_run, run_from_data
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs

NAMES = ("a", "b", "c")
LEAD_NS = 30 * NS_PER_MS
MOST_YIELDS = 50_000
WRONG = ("fails", "refuses", "refuses later", "is moved", "stays behind")
ANGLES = st.integers(-90, 90).map(float)
AXIS = st.tuples(st.booleans(), st.booleans(), st.sampled_from([0, LEAD_NS]))
"""Random axis: whether it follows paths, whether it tells its position, and its lead."""
WRONGS = st.none() | st.builds(Wrong, st.integers(1, 3 * NS_PER_S), st.sampled_from(WRONG))


@st.composite
def steps(draw: st.DrawFn, axes: dict[str, tuple[bool, bool, int]]) -> list[dict[str, Any]]:
    """Steps that such axes can do."""
    followers = [name for name, (follows, _, _) in axes.items() if follows]
    tell = [name for name, (_, tells, _) in axes.items() if tells]
    kinds = ["move", "move_by", "dwell_s", "wait_until"]
    kinds += ["line", "spline"] if followers else []
    kinds += ["pins"] if tell else []
    made: list[dict[str, Any]] = []
    for kind in draw(st.lists(st.sampled_from(kinds), min_size=1, max_size=4)):
        some = st.sets(st.sampled_from(list(axes)), min_size=1)
        match kind:
            case "move" | "move_by":
                made.append({kind: {name: draw(ANGLES) for name in sorted(draw(some))}})
            case "line":
                made.append({kind: {name: draw(ANGLES) for name in followers}})
            case "spline":
                points = [{name: draw(ANGLES) for name in followers} | {"at_s": at_s} for at_s in (2.0, 4.0)]
                made.append({kind: points})
            case "dwell_s":
                made.append({kind: draw(st.sampled_from([0.0, 0.1]))})
            case "pins":
                made.append({kind: {f"{draw(st.sampled_from(tell))}.in": draw(st.integers(0, 1))}})
            case "wait_until":
                above = draw(st.sampled_from([-1e6, 1e6]))
                made.append({kind: {"axis": draw(st.sampled_from(list(axes))), "field": "v", "above": above,
                                    "timeout_s": 0.1}})  # fmt: skip
    return made


@st.composite
def runs(draw: st.DrawFn) -> tuple[dict[str, tuple[bool, bool, int]], dict[str, Any]]:
    axes = {name: draw(AXIS) for name in NAMES[: draw(st.integers(1, 3))]}
    rules = {
        name: {"velocity_rpm": 60.0} | ({"following_error_deg": 20.0} if tells else {})
        for name, (_, tells, _) in axes.items()
    }
    how = draw(st.sampled_from(["grace", "prejudice"]))
    return axes, {"run": "r", "axes": rules, "on_fault": how, "steps": draw(steps(axes))}


class Bench:
    """A run over model axes, driven to its end."""

    def __init__(
        self,
        kinds: dict[str, tuple[bool, bool, int]],
        run: dict[str, Any],
        wrong: dict[str, Wrong | None] | None = None,
        cancel_at_ns: int | None = None,
    ) -> None:
        clock = ModelClock(SimTimeNs(0))
        self.axes = {
            name: ModelAxis(clock, follows, tells, (wrong or {}).get(name), lead_ns)
            for name, (follows, tells, lead_ns) in kinds.items()
        }
        bench = ModelAxes(clock, self.axes)
        lead_ns = max(NS_PER_MS, *(axis.lead_ns for axis in self.axes.values()))
        self.plan = plan_run(*run_from_data(run), bench.axes())
        self.execution = Execution(self.plan, bench, Soon(bench, lead_ns))
        for number, until_ns in enumerate(self.execution.run()):
            assert number < MOST_YIELDS
            assert until_ns > clock.now_ns
            clock.now_ns = SimTimeNs(until_ns)
            if cancel_at_ns is not None and until_ns >= cancel_at_ns:
                self.execution.stop("grace")
                cancel_at_ns = None

    @property
    def progress(self) -> Progress:
        return self.execution.progress

    def done_with(self, name: str) -> list[str]:
        return [what for _, what, _ in self.axes[name].used]


def at_end(bench: Bench, axis: ModelAxis) -> str:
    """End of an axis as its report has to tell it; at the very time of its end it still moves."""
    if axis.failure:
        return "failed"
    return "moves" if axis.is_under_way and axis.ends_ns == bench.progress.ended_at_ns else "stands"


@pytest.mark.long
@given(runs())
def test_a_run_in_which_nothing_goes_wrong_leads_where_it_was_planned(made: Any) -> None:
    bench = Bench(*made)
    waits_in_vain = any(step.get("wait_until", {}).get("above") == 1e6 for step in made[1]["steps"])
    assert bench.progress.state == ("failed" if waits_in_vain else "done"), bench.progress.why
    for name, axis in bench.axes.items():
        report = bench.progress.axes[name]
        assert not axis.is_held
        assert report.at_end == at_end(bench, axis)
        assert (report.position_deg is None) == (not axis.tells_position)
        if not waits_in_vain:
            assert report.commanded_deg == pytest.approx(bench.plan.ends_deg[name], abs=0.01)
            assert "stop" not in bench.done_with(name)


@given(runs(), st.tuples(*[WRONGS] * len(NAMES)), st.none() | st.integers(0, 3 * NS_PER_S))
def test_a_run_lets_go_of_what_it_held_whatever_goes_wrong(
    made: Any, wrong: tuple[Wrong | None, ...], cancel_at_ns: int | None
) -> None:
    """The models check the rest: nobody is given anything without being held, too late, or on top of what is
    under way."""
    bench = Bench(*made, dict(zip(NAMES, wrong, strict=True)), cancel_at_ns)
    assert bench.progress.is_over
    for name, axis in bench.axes.items():
        done = bench.done_with(name)
        assert (done.count("hold"), done.count("release")) == (1, 1)
        assert (done[0], done[-1]) == ("hold", "release")
        assert bench.progress.axes[name].at_end == at_end(bench, axis)
        if bench.progress.state != "done":
            stops = [about for _, what, about in axis.used if what == "stop"]
            assert stops == [bench.execution.stopping]
            assert done[done.index("stop") :] == ["stop", "release"]


@pytest.mark.long
@given(runs(), st.tuples(*[WRONGS] * len(NAMES)))
def test_the_same_run_is_the_same_again(made: Any, wrong: tuple[Wrong | None, ...]) -> None:
    first, again = (Bench(*made, dict(zip(NAMES, wrong, strict=True))) for _ in range(2))
    assert first.progress == again.progress
    assert [axis.used for axis in first.axes.values()] == [axis.used for axis in again.axes.values()]


@pytest.mark.long
@given(runs())
def test_axes_that_tell_no_position_are_moved_alike(made: Any) -> None:
    """A run gives the same motions to an axis whether or not it knows the position."""
    kinds, run = made
    run = run | {"axes": {name: {"velocity_rpm": 60.0} for name in kinds}}
    run["steps"] = [step for step in run["steps"] if "pins" not in step] or [{"dwell_s": 0.0}]
    told, untold = (
        Bench({name: (follows, tells, lead_ns) for name, (follows, _, lead_ns) in kinds.items()}, run)
        for tells in (True, False)
    )
    for name in kinds:
        assert told.done_with(name) == untold.done_with(name)
    assert told.progress.state == untold.progress.state


@pytest.mark.parametrize("what", WRONG)
def test_each_thing_that_goes_wrong_is_said(what: str) -> None:
    """Make sure that the properties above are not those of runs that all succeed."""
    axes, steps = {"a": {"following_error_deg": 20.0}}, [{"move": {"a": 90.0}}]
    run = {"run": "r", "start_in_s": 0.1, "axes": axes, "steps": steps}
    said = Bench({"a": (True, True, 0)}, run, {"a": Wrong(1, what)}).progress.why
    assert (
        said
        == {
            "fails": "a stopped: it is broken",
            "refuses": "a: it does not want to",
            "refuses later": "a: it could not",
            "is moved": "a: its mode or its set-point was changed by something else",
            "stays behind": "a is 50 deg from where it should be, 20 are allowed",
        }[what]
    )
