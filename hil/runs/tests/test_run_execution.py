"""Runs carried out on the virtual clock."""

from itertools import pairwise
from typing import Any

import pytest

from hil.config import ConfigError
from hil.runs import Execution, Progress, Soon, Told, TwinAxes
from hil.sim.inputs import Do
from hil.testing import Bench
from hil.vocab.axis import Axes

SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
SAC = {"profile": "sac"}


def bench(servos: int = 1, steppers: int = 0) -> Bench:
    devices: dict[str, Any] = {f"m{n}": SERVO for n in range(1, servos + 1)}
    devices |= {f"s{n}": SAC for n in range(1, steppers + 1)}
    made = Bench({"bench": "runs", "devices": devices})
    made.run(4100)
    for n in range(1, servos + 1):
        made.axis(f"m{n}").do("enable")
    made.run(100)
    return made


def run(*steps: dict[str, Any], axes: dict[str, Any], **top: Any) -> dict[str, Any]:
    return {"run": "r", "axes": axes, "steps": list(steps)} | top


def until(made: Bench, execution: Execution, condition: Any) -> Any:
    """Drive a run until something is so, and return the rest of its driver."""
    driver = execution.run()
    for until_ns in driver:
        made.run_until(until_ns / 1e6)
        if condition():
            return driver
    raise AssertionError("the run ended first")


def to_end(made: Bench, driver: Any) -> None:
    for until_ns in driver:
        made.run_until(until_ns / 1e6)


def test_an_s_curve_is_followed_as_closely_as_the_law_does_it_alone() -> None:
    made = bench()
    progress = made.perform(
        run({"move": {"m1": 0.0}}, {"move": {"m1": 360.0}}, axes={"m1": {"velocity_rpm": 120.0}})
    )
    assert progress.state == "done"
    report = progress.axes["m1"]
    assert abs(report.position_deg - 360) < 0.2

    # The same set-points given one by one to a board that knows no runs: the closed-loop model alone.
    alone = bench()
    execution = alone.execute(
        run({"move": {"m1": 0.0}}, {"move": {"m1": 360.0}}, axes={"m1": {"velocity_rpm": 120.0}})
    )
    (phrase,) = execution.plan.phrases
    worst = _streamed(alone, phrase.paths["m1"], phrase.duration_ns)
    assert report.error_max_deg == pytest.approx(worst, rel=0.10)


def _streamed(made: Bench, path: Any, duration_ns: int) -> float:
    """Following error where each control step's set-point is written from outside, as often as it can be."""
    from hil.firmware.set_point_paths import at

    axis, begin_ns, worst = made.axis("m1"), made.now_ns, 0.0
    for into_ns in range(0, duration_ns, 153_854):
        made.run_until((begin_ns + into_ns) / 1e6)
        axis.do("position", position_deg=at(path, into_ns)[0])
        made.run(0.1)
        state = axis.snapshot()
        worst = max(worst, abs(state.r - state.yw))
    return worst


def test_32_axes_start_at_one_control_time() -> None:
    made = bench(servos=32)
    axes = {f"m{n}": {"velocity_rpm": 60.0} for n in range(1, 33)}
    recordings = {name: made.axis(name).record("r", "following", interval_ms=0.05) for name in axes}
    made.perform(run({"move": {name: 20.0 for name in axes}}, axes=axes))
    begins, moves = set(), set()
    for recording in recordings.values():
        begins.add(next(row[0] for row in recording.rows if row[2]))
        moves.add(next(after[0] for before, after in pairwise(recording.rows) if after[1] != before[1]))
    assert len(begins) == 1
    assert len(moves) == 1


def test_steppers_start_at_the_same_nanosecond() -> None:
    made = bench(servos=0, steppers=3)
    axes = {f"s{n}": {"velocity_rpm": 60.0} for n in (1, 2, 3)}
    progress = made.perform(run({"move": {name: 90.0 for name in axes}}, axes=axes))
    assert progress.state == "done"
    assert {round(report.position_deg, 1) for report in progress.axes.values()} == {90.0}
    assert len({made.device(name).pin("clk").edges()[0][0] for name in axes}) == 1


class Ahead:
    """The bench of a run whose clock is ahead of its groups, as the wall's is on a busy machine."""

    def __init__(self, bench: Any, by_ns: int) -> None:
        self._bench, self._by_ns = bench, by_ns

    @property
    def now_ns(self) -> int:
        return self._bench.now_ns + self._by_ns

    def __getitem__(self, device: str) -> Any:
        return self._bench[device]


@pytest.mark.parametrize("behind_ms", [1, 30, 400])
def test_a_board_that_is_behind_the_wall_is_not_taken_for_one_that_was_interfered_with(
    behind_ms: int,
) -> None:
    made = bench(steppers=1)
    axes = {"m1": {"velocity_rpm": 60.0}, "s1": {"velocity_rpm": 60.0}}
    made_for = made.execute(run({"move": {"m1": 40.0, "s1": 20.0}}, {"move": {"m1": 0.0}}, axes=axes))
    ahead = Ahead(made_for._bench, behind_ms * 1_000_000)
    execution = Execution(made_for.plan, ahead, Soon(ahead, 2_000_000))
    for until_ns in execution.run():
        made.run_until((until_ns - behind_ms * 1_000_000) / 1e6)
    assert (execution.progress.state, execution.progress.why) == ("done", None)


@pytest.mark.parametrize("late_ms", [50, 4000])
def test_a_path_that_is_given_late_is_not_taken_for_a_change(late_ms: int) -> None:
    """The event loop was held up between the plan and the input: the path, or all of it, lies in the past."""
    made = bench()
    made_for = made.execute(run({"move": {"m1": 20.0}}, axes={"m1": {"velocity_rpm": 60.0}}))
    execution = Execution(made_for.plan, made_for._bench, Soon(made_for._bench, -late_ms * 1_000_000))
    for until_ns in execution.run():
        made.run_until(until_ns / 1e6)
    assert (execution.progress.state, execution.progress.why) == ("done", None)


class Late:
    """Axes of a bench whose clock goes on before one is given its first path, as on a busy machine."""

    def __init__(self, made: Bench, axes: Axes, name: str, late_ms: float) -> None:
        self._made, self._axes, self._name, self._late_ms = made, axes, name, late_ms

    @property
    def now_ns(self) -> int:
        return self._axes.now_ns

    def __getitem__(self, device: str) -> Any:
        axis = self._axes[device]
        if device == self._name:
            follow = axis.follow

            def follow_late(path: Any, start_ns: int) -> Any:
                self._made.run(self._late_ms)
                self._late_ms = 0
                return follow(path, start_ns)

            axis.follow = follow_late  # type: ignore[method-assign]
        return axis


@pytest.mark.parametrize("late_ms", [30, 90, 700])
@pytest.mark.parametrize("late", ["m1", "m2", "m3"])
def test_axes_of_which_one_misses_the_start_go_in_step(late: str, late_ms: float) -> None:
    """The event loop was held up while the axes were given their paths: they begin again, together."""
    made = bench(servos=3)
    shares = {"m1": 1.0, "m2": 0.5, "m3": -0.25}
    for name in shares:
        made.axis(name).do("position", position_deg=0.0)
    made.run(100)
    limits = {"velocity_rpm": 60.0, "acceleration_rpm_per_s": 600.0}
    line = {"line": {name: 180 * share for name, share in shares.items()}}
    made_for = made.execute(run(line, axes=dict.fromkeys(shares, limits)))
    axes: Any = Late(made, made_for._bench, late, late_ms)
    execution = Execution(made_for.plan, axes, Soon(axes, 20_000_000))
    recordings = {name: made.axis(name).record("r", interval_ms=1) for name in shares}
    to_end(made, execution.run())
    assert (execution.progress.state, execution.progress.why) == ("done", None)
    rows = {name: [r for _, r in recording.rows] for name, recording in recordings.items()}
    assert [values[-1] for values in rows.values()] == [180.0, 90.0, -45.0]
    begun = max(number for number, r in enumerate(rows[late]) if abs(r) < 1e-3)
    for name, share in shares.items():
        off_deg = [abs(r - share * m1) for r, m1 in zip(rows[name], rows["m1"], strict=True)][begun:]
        assert max(off_deg) < 1e-3
        r = rows[name]
        assert max(abs(b - a) / 0.02 for a, b in zip(r, r[20:], strict=False)) < 60.0 * 6 * 1.02
        bends = [abs(a - 2 * b + c) / 0.02**2 for a, b, c in zip(r, r[20:], r[40:], strict=False)]
        assert max(bends) < 600.0 * 6 * 1.15  # control steps are 0.15 ms apart


def test_a_bench_that_misses_a_start_that_others_were_told_says_so() -> None:
    made = bench()
    made_for = made.execute(run({"move": {"m1": 20.0}}, axes={"m1": {"velocity_rpm": 60.0}}))
    baton = Told()
    baton.starts_ns[0] = made.now_ns - 70_000_000
    execution = Execution(made_for.plan, made_for._bench, baton)
    to_end(made, execution.run())
    assert execution.progress.state == "failed"
    assert execution.progress.why == "this computer was too busy: the start was 70 ms ago"
    assert made.axis("m1").snapshot().following == 0


def test_a_mixed_run_with_waits_pins_and_repetitions() -> None:
    made = bench(servos=2, steppers=1)
    axes = {"m1": {"velocity_rpm": 120.0}, "m2": {"velocity_rpm": 120.0}, "s1": {}}
    progress = made.perform(
        run(
            {"label": "again", "move": {"m1": 0.0, "m2": 0.0, "s1": 0.0}},
            {"line": {"m1": 90.0, "m2": 45.0}},
            {"pins": {"m1.D3": 1}},
            {"move": {"m1": 10.0, "s1": 45.0}},
            {"wait_until": {"axis": "s1", "field": "position_deg", "above": 44.0}},
            {"repeat": {"label": "again", "times": 2}},
            axes=axes,
        )
    )
    assert (progress.state, progress.step, progress.steps) == ("done", 15, 15)
    assert abs(progress.axes["m1"].position_deg - 10) < 0.3
    assert abs(progress.axes["s1"].position_deg - 45) < 0.3
    assert made.axis("m1").snapshot().pin_d3 == 1


def test_the_same_run_twice_is_the_same() -> None:
    steps: list[dict[str, Any]] = [{"move": {"m1": 50.0, "s1": 30.0}}, {"line": {"m1": 0.0, "m2": 9.0}}]

    def once() -> Progress:
        made = bench(servos=2, steppers=1)
        return made.perform(run(*steps, axes={"m1": {}, "m2": {}, "s1": {}}))

    assert once() == once()


@pytest.mark.parametrize(("how", "longest_ms"), [("grace", 200.0), ("prejudice", 30.0)])
def test_a_cancelled_run_ends_at_a_known_place(how: Any, longest_ms: float) -> None:
    made = bench(servos=2, steppers=1)
    axes = {"m1": {"velocity_rpm": 60.0}, "m2": {"velocity_rpm": 60.0}, "s1": {"velocity_rpm": 30.0}}
    execution = made.execute(run({"move": {"m1": 720.0, "m2": 720.0, "s1": 720.0}}, axes=axes))
    driver = until(made, execution, lambda: made.axis("m1").snapshot().r > 90)
    execution.stop(how)
    began_ns = made.now_ns
    for until_ns in driver:  # it has not ended before all stand and it is known where
        assert execution.progress.state == "running"
        made.run_until(until_ns / 1e6)
    progress = execution.progress
    assert progress.state == "cancelled"
    assert progress.axes["m1"].position_deg > 90
    assert (made.now_ns - began_ns) / 1e6 < longest_ms + 2000  # a SAC's own ramp takes its time
    made.run(300)
    for name in axes:
        state = made.axis(name).snapshot()
        assert abs(state.velocity_rpm) < 2
        assert abs(state.position_deg - progress.axes[name].position_deg) < 5


def test_an_axis_that_is_jammed_stops_all() -> None:
    made = bench(servos=2)
    axes = {"m1": {"velocity_rpm": 120.0, "following_error_deg": 10.0}, "m2": {"velocity_rpm": 120.0}}
    execution = made.execute(run({"move": {"m1": 720.0, "m2": 720.0}}, axes=axes))
    driver = until(made, execution, lambda: made.axis("m1").snapshot().r > 60)
    made.fault("shaft_jam", "m1")
    to_end(made, driver)
    assert execution.progress.state == "failed"
    assert (execution.progress.why or "").startswith("m1 is ")
    assert made.axis("m2").snapshot().following == 0
    assert execution.progress.axes["m2"].position_deg < 720


def test_a_wait_that_is_not_met_fails_the_run() -> None:
    made = bench()
    wait = {"axis": "m1", "field": "yw", "above": 1e5, "timeout_s": 0.3}
    progress = made.perform(run({"wait_until": wait}, axes={"m1": {}}))
    assert progress.state == "failed"
    assert progress.why == "m1.yw was not in its range for 0.3 s"
    assert (progress.ended_at_ns or 0) - (progress.started_at_ns or 0) == pytest.approx(300_000_000, abs=15e6)


def test_a_loop_that_is_switched_off_on_the_way_is_noticed() -> None:
    made = bench(servos=2)
    steps: list[dict[str, Any]] = [
        {"move": {"m1": 90.0, "m2": 90.0}},
        {"wait_until": {"axis": "m1", "field": "yw", "above": 0.0}},
        {"move": {"m1": 0.0}},
    ]
    execution = made.execute(run(*steps, axes={"m1": {}, "m2": {}}))
    driver = until(made, execution, lambda: made.axis("m1").snapshot().r > 30)
    made.axis("m1").do("disable")
    to_end(made, driver)
    assert execution.progress.state == "failed"
    assert execution.progress.why == "m1: its control loop is off; somebody disabled it, or reset the board"


def taken_over(kind: str, made: Bench) -> None:
    match kind:
        case "disabled":
            made.axis("m1").do("disable")
        case "reset":
            made.device("m1").reset()
        case "another move":
            made.axis("m1").do("move_rel", angle_deg=5.0)
        case _:
            made.port("m1").write(kind.encode())


@pytest.mark.parametrize("kind", ["disabled", "reset", "another move", "n", "v", "x", "r90\r", "t"])
def test_a_servo_that_is_taken_over_on_the_way_fails_the_run(kind: str) -> None:
    made = bench(servos=2)
    execution = made.execute(run({"move_by": {"m1": 1440.0, "m2": 720.0}}, axes={"m1": {}, "m2": {}}))
    driver = until(made, execution, lambda: made.axis("m1").snapshot().r > 90)
    taken_over(kind, made)
    to_end(made, driver)
    progress = execution.progress
    assert progress.state == "failed"
    assert (progress.why or "").startswith("m1")
    made.run(500)
    for name in ("m1", "m2"):  # the report is true
        state = made.axis(name).snapshot()
        if progress.axes[name].at_end == "stands":
            assert abs(state.velocity_rpm) < 5
            assert state.yw == pytest.approx(progress.axes[name].position_deg, abs=1.0)
        else:
            assert (progress.axes[name].at_end, state.loop_on) == ("off", 0)


def test_a_stepper_that_is_reset_on_the_way_fails_the_run() -> None:
    made = bench(servos=0, steppers=1)
    execution = made.execute(run({"move_by": {"s1": 720.0}}, axes={"s1": {}}))
    driver = until(made, execution, lambda: made.axis("s1").snapshot().commanded_deg > 90)
    made.device("s1").reset()
    to_end(made, driver)
    assert execution.progress.state == "failed"
    assert "something else moved or reset it" in (execution.progress.why or "")


def test_a_verb_that_is_refused_when_its_time_has_come_fails_the_run() -> None:
    made = bench(servos=0, steppers=1)
    wanted = run({"dwell_s": 0.5}, {"move": {"s1": 90.0}}, axes={"s1": {}})
    execution = made.execute(wanted)
    TwinAxes(made._runtime, made._time.sampler)["s1"]  # stands for the axis in another run
    driver = until(made, execution, lambda: made.now_ns >= 4_300_000_000)
    made.port("s1").write(b"xm2000v60\r")
    to_end(made, driver)
    assert (execution.progress.why or "").startswith("s1: move_abs: it moves, and where it will be is not")
    made.run(2000)
    assert made.perform(wanted).state == "done"


def test_what_others_gave_for_later_and_is_refused_is_no_fault_of_the_run() -> None:
    made = bench(servos=1, steppers=1)
    execution = made.execute(run({"move": {"m1": 90.0}}, {"dwell_s": 1.0}, axes={"m1": {}, "s1": {}}))
    made.axis("s1").do("move_abs", position_deg=90.0, velocity_rpm=60.0)
    move = Do("move_abs", (("position_deg", 0.0), ("velocity_rpm", 60.0)), made.now_ns + 20_000_000)
    made._runtime.apply_to(made._runtime.devices["s1"], move)
    to_end(made, execution.run())
    assert execution.progress.state == "done", execution.progress.why


def test_a_servo_that_turns_takes_no_part() -> None:
    made = bench()
    made.axis("m1").do("velocity", velocity_rpm=100.0)
    made.run(500)
    with pytest.raises(ConfigError, match="it follows a path or turns"):
        made.execute(run({"move": {"m1": 0.0}}, axes={"m1": {}}))


def test_grace_becomes_prejudice_when_it_is_asked_for() -> None:
    made = bench()
    slow = {"velocity_rpm": 60.0, "acceleration_rpm_per_s": 20.0}
    execution = made.execute(run({"move": {"m1": 3600.0}}, axes={"m1": slow}))
    driver = until(made, execution, lambda: made.axis("m1").snapshot().r > 400)
    execution.stop("grace")
    made.run_until(next(driver) / 1e6)
    began_ns = made.now_ns
    assert execution.stopping == "grace"
    execution.stop("prejudice")
    to_end(made, driver)
    assert execution.stopping == "prejudice"
    assert made.now_ns - began_ns < 400e6
