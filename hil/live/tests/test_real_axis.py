"""Real boards as axes of runs, on simulated time: what is typed at them, when, and who has them."""

import asyncio
from typing import Any

import pytest
from simulated_world import World, in_world

from hil.firmware.set_point_paths import at
from hil.runs import Execution, Progress, Soon, plan_run, run_from_data
from hil.vocab.axis import Axis
from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_MS
from hil.vocab.verbs import VerbRefused

RULES = {"velocity_rpm": 120.0, "acceleration_rpm_per_s": 1200.0, "jerk_rpm_per_s2": 1e5}
ALL = {"m1": RULES, "m2": RULES, "s2": RULES}


def execution(world: World, *steps: dict[str, Any]) -> Execution:
    run = {"run": "r", "axes": ALL, "steps": list(steps)}
    lead_ns = max(world.axes[name].lead_ns for name in ALL)
    return Execution(plan_run(*run_from_data(run), world.axes.axes()), world.axes, Soon(world.axes, lead_ns))


async def to_end(world: World, doing: Execution) -> Progress:
    for until_ns in doing.run():
        await asyncio.sleep(max((until_ns - world.axes.now_ns) / 1e9, 0.0))
    return doing.progress


async def held(world: World, name: str) -> Axis:
    await world.taken()
    axis = world.axes[name]
    axis.hold()
    return axis


def test_they_move_beside_a_twin() -> None:
    async def doing(world: World) -> None:
        await world.taken()
        steps = ({"move": {"m1": 90.0, "m2": 90.0, "s2": 90.0}}, {"line": {"m1": 0.0, "m2": 45.0}})
        done = await to_end(world, execution(world, *steps))
        assert done.state == "done", done.why
        assert world.far.axis("m2").snapshot().r == pytest.approx(45.0, abs=0.001)
        assert world.far.axis("s2").snapshot().commanded_deg == pytest.approx(90.0)
        for name, commanded_deg in (("m2", 45.0), ("s2", 90.0)):
            report = done.axes[name]
            assert report.commanded_deg == pytest.approx(commanded_deg)
            assert (report.position_deg, report.error_max_deg, report.at_end) == (None, None, "stands")
        assert (done.axes["m1"].error_max_deg or 99.0) < 5

    in_world(doing)


def test_set_points_are_typed_at_their_times_and_the_last_exactly() -> None:
    path = (PathPiece(500 * NS_PER_MS, 10.0, 100.0), PathPiece(0, 60.0))

    async def doing(world: World) -> None:
        axis = await held(world, "m2")
        line = world.lines["m2"]
        line.written.clear()
        start_s = world.time() + 0.3
        axis.follow(path, world.axes.now_ns + 300 * NS_PER_MS)
        assert axis.state().is_under_way
        while axis.state().is_under_way:
            await asyncio.sleep(0.01)
        typed = [(at_s - start_s, float(data[1:])) for at_s, data in line.written]
        assert len(typed) == 26  # 50 a second, and the last
        for into_s, angle_deg in typed:
            assert angle_deg == pytest.approx(at(path, round(into_s * 1e9))[0], abs=0.001)
        assert typed[-1] == (pytest.approx(0.5, abs=1e-6), 60.0)
        assert axis.state().commanded_deg == 60.0

    in_world(doing)


SLOW_LINES = [
    ("m2", 0.0, "failed", "was not answered"),
    ("m2", 600.0, "done", ""),
    ("s2", 0.0, "failed", " ms after the start; its line is too slow"),
    ("s2", 600.0, "done", ""),
]


@pytest.mark.parametrize(("name", "line_delay_ms", "end", "why"), SLOW_LINES)
def test_a_board_behind_a_slow_line_is_told_earlier_and_waited_for(
    name: str, line_delay_ms: float, end: str, why: str
) -> None:
    async def doing(world: World) -> None:
        await world.taken()
        world.lines[name].late_s = 0.55
        done = await to_end(world, execution(world, {"move": {"m1": 90.0, name: 90.0}}))
        assert (done.state, why in (done.why or "")) == (end, True), done.why
        if end == "done":
            snapshot = world.far.axis(name).snapshot()
            there_deg = snapshot.r if name == "m2" else snapshot.commanded_deg
            assert there_deg == pytest.approx(90.0, abs=0.001)

    in_world(doing, line_delay_ms)


def test_a_board_is_a_runs_own_until_it_stands() -> None:
    async def doing(world: World) -> None:
        axis = await held(world, "s2")
        axis.move(360.0, 60, world.axes.now_ns + axis.lead_ns)
        await asyncio.sleep(1.0)
        axis.stop("grace", 600.0)
        axis.release()
        assert world.end("s2").is_held
        assert axis.state().is_moving
        while axis.state().is_moving:
            await asyncio.sleep(0.01)
        await asyncio.sleep(0)
        assert not world.end("s2").is_held
        assert world.far.axis("s2").snapshot().motion_state == 0
        assert axis.state().commanded_deg is None
        assert "is not known" in (world.axes.axes()["s2"].why_not or "")

    in_world(doing)


@pytest.mark.parametrize("how", ["grace", "prejudice"])
def test_a_run_that_is_cancelled_stops_them(how: Any) -> None:
    async def doing(world: World) -> None:
        await world.taken()
        run = execution(world, {"move": {"m1": 7200.0, "m2": 7200.0, "s2": 7200.0}})
        world.call_later(2.0, run.stop, how)
        done = await to_end(world, run)
        assert (done.state, done.axes["s2"].commanded_deg) == ("cancelled", None)
        assert world.far.axis("s2").snapshot().motion_state == 0
        assert world.far.axis("m2").snapshot().r == pytest.approx(done.axes["m2"].commanded_deg, abs=0.001)

    in_world(doing)


@pytest.mark.parametrize("name", ["m2", "s2"])
@pytest.mark.parametrize("back_s", [None, 0.005])
def test_a_board_that_goes_away_ends_the_run_and_then_the_daemon(name: str, back_s: float | None) -> None:
    """Nobody waits at the daemon's end for what was broken off."""

    async def doing(world: World) -> None:
        await world.taken()
        line = world.lines[name]

        def goes() -> None:
            line.is_there = False
            if back_s:
                world.call_later(back_s, comes)

        def comes() -> None:
            line.is_there, line.connects = True, 2

        run = execution(world, {"move": {"m1": 7200.0, "m2": 7200.0, "s2": 7200.0}})
        world.call_later(2.0, goes)
        done = await to_end(world, run)
        assert done.state == "failed"
        assert (done.why or "").startswith(f"{name} stopped: ")
        assert "away" in (done.why or "")
        await world.devices.stop()

    in_world(doing)


def test_the_daemons_end_stops_them() -> None:
    async def doing(world: World) -> None:
        axis = await held(world, "s2")
        axis.move(7200.0, 60, world.axes.now_ns + axis.lead_ns)
        await asyncio.sleep(1.0)
        assert world.far.axis("s2").snapshot().motion_state
        await world.devices.stop()
        assert world.far.axis("s2").snapshot().motion_state == 0

    in_world(doing)


def test_nobody_drives_their_inputs() -> None:
    async def doing(world: World) -> None:
        axis = await held(world, "s2")
        with pytest.raises(VerbRefused, match="its wires"):
            axis.set_pin("sync", 1, world.axes.now_ns)

    in_world(doing)
