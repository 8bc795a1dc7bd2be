"""Master in a process of its own beside a running bench: at a pty, over tcp and RFC 2217, several lines."""

import asyncio
import time
from collections.abc import Iterator

import pytest

from device_profiles.sac.board import PROFILE
from hil.gcode.reader import read_program
from hil.master import (
    LineGone,
    LineRun,
    LineUnreachable,
    LiveMaster,
    Outcome,
    RunReport,
    RunState,
    open_line,
    path_run,
)
from hil.testing import ServedBench, live
from hil.toolpath.machine import machine_from_data
from hil.toolpath.node_phrases import NodePhrases
from hil.toolpath.path_plan import plan_path

pytestmark = pytest.mark.long
PATIENCE_S = 60
BUSY_MS = 250
"""Latency of programs, as `hil gcode` has it: other tests run beside these."""
CIRCLE = b"G21 G91 G64 P0.05\nG1 X5 F1200\nG2 X0 Y0 I-5 J0\n"
NODES = range(4, 7)
TAPS = {"master": {"port": "pty"}, "net": {"port": "tcp"}, "far": {"port": "rfc2217"}}


def config(speed: float = 1) -> dict[str, object]:
    names = [f"s{number}" for number in NODES]
    wires = {
        "bus0": {"stations": names[:2], "taps": TAPS},
        "bus1": {"stations": names[2:], "taps": {"master": {"port": "pty"}}},
    }
    devices = {name: {"profile": "sac"} for name in names}
    return {"bench": "lines", "speed": speed, "devices": devices, "segments": wires}


def address(bench: ServedBench) -> ServedBench:
    for number in NODES:
        bench.type(f"s{number}", b"$CM%d\r" % number, b"$R\r", until=b"SAC>")
    return bench


@pytest.fixture(scope="module")
def bench() -> Iterator[ServedBench]:
    with live(config()) as made:
        yield address(made)


def at(bench: ServedBench, tap: str, latency_ms: int | None = None):
    latency_ns = None if latency_ms is None else latency_ms * 1_000_000
    return open_line(tap, runtime_dir=bench.folder / "run", latency_ns=latency_ns)


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore:set(Daemon|Name)")  # pyserial's rfc2217://
@pytest.mark.parametrize("tap", ["bus0.master", "bus0.net", "bus0.far"])
def test_nodes_are_commanded_and_found(bench: ServedBench, tap: str) -> None:
    async def run() -> None:
        async with asyncio.timeout(PATIENCE_S), at(bench, tap) as live:
            assert (await live.send(4, "v150")).outcome is Outcome.DONE
            found = await live.scan(range(4, 40))
            assert [row.address for row in found] == [4, 5]

    asyncio.run(run())


def test_several_lines_at_once(bench: ServedBench) -> None:
    async def run() -> None:
        async with (
            asyncio.timeout(PATIENCE_S),
            at(bench, "bus0.master") as first,
            at(bench, "bus1.master") as second,
        ):
            found = await asyncio.gather(first.scan(range(4, 10)), second.scan(range(4, 10)))
            assert [[row.address for row in rows] for rows in found] == [[4, 5], [6]]
            for live, node in ((first, 4), (second, 6)):
                assert (await live.send(node, "m50v300s")).outcome is Outcome.DONE
            await asyncio.gather(first.release(), second.release())

    before = [bench.ask("state", device=name)["commanded_deg"] for name in ("s4", "s6")]
    asyncio.run(run())
    deadline_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline_s:
        now = [bench.ask("state", device=name)["commanded_deg"] for name in ("s4", "s6")]
        if [b - a for a, b in zip(before, now, strict=True)] == [90, 90]:
            return
    raise AssertionError(f"from {before} to {now}")


def test_a_scan_takes_about_what_was_calculated(bench: ServedBench) -> None:
    async def run() -> float:
        async with asyncio.timeout(PATIENCE_S), at(bench, "bus0.master") as live:
            began_s = time.monotonic()
            found = await live.scan(range(4, 56))
            assert [row.address for row in found] == [4, 5]
            return (time.monotonic() - began_s) / (live.master.scan_ns(52, 2) / 1e9)

    assert 0.99 < asyncio.run(run()) < 2  # 1.03 on a computer that does nothing else


def test_a_bench_that_ends_leaves_an_error_with_what_was_outstanding() -> None:
    async def run(bench: ServedBench) -> None:
        async with asyncio.timeout(PATIENCE_S), at(bench, "bus0.master") as live:
            await live.send(4, "v100")
            bench.ask("stop")
            sent = [live.start(9, "v100") for _ in range(100)]
            with pytest.raises(LineGone, match=r"bus0\.master has gone .*; 9 v100: not (known|sent)"):
                await live.settled(sent)

    with live(config(), capture=False) as made:
        asyncio.run(run(address(made)))


def test_a_bench_that_is_five_times_as_fast(bench: ServedBench) -> None:
    async def run(fast: ServedBench) -> None:
        async with asyncio.timeout(PATIENCE_S), at(fast, "bus0.master") as live:
            for _ in range(20):
                assert (await live.send(4, "v100")).outcome is Outcome.DONE
            found = await live.scan(range(4, 40))
            assert [row.address for row in found] == [4, 5]

    with live(config(speed=5)) as made:
        asyncio.run(run(address(made)))


def program(live: LiveMaster, text: bytes) -> LineRun:
    axis = {"steps_per_mm": 20, "min_mm": -99, "max_mm": 99, "velocity_mm_per_min": 1500}
    axes = {
        letter: {**axis, "node": node, "acceleration_mm_per_s2": 200} for letter, node in (("x", 4), ("y", 5))
    }
    machine = machine_from_data({"machine": "mill", "axes": axes, "latency_ms": 10})
    read = read_program(text + b"M2\n")
    plan = plan_path(read.motions, machine, "part.ngc")
    assert [*read.problems, *plan.problems] == []
    return path_run(live.master, machine, NodePhrases(machine, PROFILE.paths).of(plan))


def pulses_of(bench: ServedBench) -> list[float]:
    return [bench.ask("state", device=name)["commanded_deg"] / 0.9 for name in ("s4", "s5")]


@pytest.mark.parametrize("tap", ["bus0.master", "bus0.net"])
def test_a_program_is_carried_out(bench: ServedBench, tap: str) -> None:
    async def run() -> RunReport:
        async with asyncio.timeout(PATIENCE_S), at(bench, tap, BUSY_MS) as live:
            return await live.carry_out(program(live, CIRCLE))

    before = pulses_of(bench)
    report = asyncio.run(run())
    after = pulses_of(bench)
    assert (report.state, report.why) == (RunState.ENDED, "")
    assert (
        [b - a for a, b in zip(before, after, strict=True)]
        == [each.pulses for each in report.axes]
        == [200, 0]
    )


def test_a_program_is_stopped_with_grace_and_its_places_are_true(bench: ServedBench) -> None:
    async def run() -> RunReport:
        async with asyncio.timeout(PATIENCE_S), at(bench, "bus0.master", BUSY_MS) as live:
            carried_out = program(live, CIRCLE * 3)
            going_on = asyncio.create_task(live.carry_out(carried_out))
            while carried_out.progress(live.now_ns()).done_s < 1 and not going_on.done():
                await asyncio.sleep(0.05)
            live.stop_run()
            return await going_on

    before = pulses_of(bench)
    report = asyncio.run(run())
    after = pulses_of(bench)
    assert report.state is RunState.STOPPED
    turned = [b - a for a, b in zip(before, after, strict=True)]
    assert turned == pytest.approx([each.pulses for each in report.axes])


def test_a_bench_that_ends_in_the_middle_of_a_program_is_told_with_the_places() -> None:
    async def run(bench: ServedBench) -> RunReport:
        async with asyncio.timeout(PATIENCE_S), at(bench, "bus0.master", BUSY_MS) as live:
            carried_out = program(live, CIRCLE * 3)
            going_on = asyncio.create_task(live.carry_out(carried_out))
            while carried_out.progress(live.now_ns()).done_s < 1 and not going_on.done():
                await asyncio.sleep(0.05)
            bench.ask("stop")
            return await going_on

    with live(config(), capture=False) as made:
        report = asyncio.run(run(address(made)))
    assert report.state is RunState.FAILED
    assert report.why.startswith("bus0.master has gone")
    assert report.why.endswith("axes may still move")
    assert [each.is_known for each in report.axes] == [False, False]


def test_a_tap_that_there_is_not_is_told(bench: ServedBench) -> None:
    async def run() -> None:
        async with at(bench, "bus0.mister"):
            pass

    with pytest.raises(LineUnreachable, match=r'did you mean "bus0\.master"'):
        asyncio.run(run())
