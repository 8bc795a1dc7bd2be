"""Runs over many benches, which all are in this process: model axes, and a wire that is late or loses."""

import asyncio
import json
import selectors
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import pytest
from model_axes import ModelAxes, ModelAxis

from hil.config import ConfigError
from hil.live.core_thread import WallClock
from hil.live.reservations import Reservations
from hil.live.runs.asked_again import asked_again
from hil.live.runs.other_benches import OtherBenches
from hil.live.runs.part import Parts
from hil.live.runs.queue import RunQueue
from hil.runs import Progress
from hil.vocab.bridge_protocol import Answered, BenchGone
from hil.vocab.desk_protocol import LOCAL, Source
from hil.vocab.verbs import VerbRefused

STEP = {"move": 90.0}


class _NoWait(selectors.DefaultSelector):
    """Selector that lets the time pass in which nothing is ready."""

    now_s = 1000.0

    def select(self, timeout: float | None = None) -> Any:
        self.now_s += timeout or 0.0
        return super().select(0)


class VirtualLoop(asyncio.SelectorEventLoop):
    def __init__(self) -> None:
        self._time = _NoWait()
        super().__init__(self._time)

    def time(self) -> float:
        return self._time.now_s


class Clock:
    """Time of all benches, by the loop's."""

    @property
    def now_ns(self) -> int:
        return round(asyncio.get_running_loop().time() * 1e9)


@dataclass
class Question:
    to: str
    given: Mapping[str, Any]
    at_s: float
    number: int
    """Counts those to this bench that ask for the same, from 1."""


@dataclass
class Wire:
    """All benches, and how long a message takes one way. ``loses``: says which questions are lost."""

    way_s: Callable[[str], float] = lambda bench: 0.001
    loses: Callable[[Question], bool] = lambda question: False
    copies: int = 1
    parts: dict[str, Parts] = field(default_factory=dict)
    clocks: dict[str, WallClock] = field(default_factory=dict)
    asked: Counter[tuple[str, str]] = field(default_factory=Counter)
    refused: list[str] = field(default_factory=list)

    def door(self, here: str) -> "Door":
        return Door(self, here)


@dataclass
class Door:
    wire: Wire
    here: str

    async def ask_bench(
        self, source: Source, bench: str, rest: str, given: Mapping[str, Any], timeout_s: float
    ) -> Answered:
        wire, loop = self.wire, asyncio.get_running_loop()
        sent = json.loads(json.dumps(given))
        which = f"{given['do']} {given.get('phrase', '')}"
        wire.asked[bench, which] += 1
        question = Question(bench, sent, loop.time() - 1000.0, wire.asked[bench, which])
        asked_ns = wire.clocks[self.here].times_ns()[1]

        async def exchange() -> dict[str, Any]:
            await asyncio.sleep(wire.way_s(bench))
            if wire.loses(question):
                await asyncio.sleep(timeout_s + 1)
            asking = [wire.parts[bench].answer(source, rest.split("/")[1], sent) for _ in range(wire.copies)]
            answer, *others = await asyncio.gather(*asking, return_exceptions=True)
            if isinstance(answer, BaseException):
                wire.refused.append(str(answer))
                raise answer
            assert [other for other in others if isinstance(other, BaseException)] == []
            wall_ns = wire.clocks[bench].times_ns()[1]
            await asyncio.sleep(wire.way_s(bench))
            return {**answer, "wall_ns": wall_ns}

        try:
            async with asyncio.timeout(timeout_s):
                content = await exchange()
        except TimeoutError:
            raise BenchGone(f"the bench {bench} did not answer within {timeout_s:g} s") from None
        return Answered(content, asked_ns, wire.clocks[self.here].times_ns()[1])

    async def stop_others(self, source: Source, how: str, timeout_s: float) -> Sequence[dict[str, Any]]:
        return ()

    async def benches(self) -> Sequence[str]:
        return [name for name in self.wire.parts if name != self.here]

    def name_clash(self) -> None:
        return None


def make(wire: Wire, names: Sequence[str]) -> dict[str, RunQueue]:
    """Make benches with an axis ``m1`` each, whose clocks are apart."""
    queues = {}
    for number, name in enumerate(names):
        clock: Any = Clock()
        axes = ModelAxes(clock, {"m1": ModelAxis(clock, follows_paths=True, tells_position=True)})
        configured: Any = SimpleNamespace(config=SimpleNamespace(bench=name, speed=1.0))
        wall = wire.clocks[name] = WallClock(clock, 1.0, number * 10**9)
        others = OtherBenches({"wire": wire.door(name)})  # type: ignore[dict-item]
        reservations = Reservations({})
        queues[name] = RunQueue(axes, configured, wall, others, reservations)
        wire.parts[name] = Parts(queues[name], axes, configured, wall, reservations)
    return queues


def perform(
    wire: Wire,
    count: int = 3,
    steps: Sequence[Any] = (STEP,),
    after: Callable[[Progress], None] | None = None,
    **top: Any,
) -> tuple[Progress, dict[str, Progress]]:
    """Carry a run out over benches; answers its progress, and those of the parts of the others."""

    async def perform() -> tuple[Progress, dict[str, Progress]]:
        queues = make(wire, [f"b{number}" for number in range(count)])
        axes = ["m1", *(f"b{number}/m1" for number in range(1, count))]
        told = [step if "move" not in step else {"move": dict.fromkeys(axes, step["move"])} for step in steps]
        text = json.dumps({"run": "r", "axes": {axis: {} for axis in axes}, "steps": told} | top)
        progress = await queues["b0"].submit(LOCAL, text)  # type: ignore[misc]
        while not progress.is_over:
            await asyncio.sleep(0.01)
        await asyncio.sleep(5)
        for queue in queues.values():
            await queue.close()
        return progress, {
            name: queue.progress["r"] for name, queue in queues.items() if "r" in queue.progress
        }

    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        return runner.run(perform())


def test_fifty_benches_begin_at_one_time() -> None:
    progress, parts = perform(Wire(), 50)
    assert (progress.state, progress.why) == ("done", None)
    assert {part.state for part in parts.values()} == {"done"}
    assert len(parts) == 50
    apart_ns = [bench.began_apart_ns for bench in progress.benches.values()]
    assert len(apart_ns) == 49
    assert all(apart is not None and abs(apart) < 1_000 for apart in apart_ns), apart_ns


def test_benches_are_looked_at_and_joined_at_once() -> None:
    progress, _ = perform(Wire(way_s=lambda bench: 0.015), 30)
    assert progress.state == "done"
    assert progress.started_at_ns is not None
    assert progress.started_at_ns / 1e9 - 1000 < 1.0  # one after the other takes 8 s


def test_the_time_when_motion_began_is_told() -> None:
    progress, parts = perform(Wire(), steps=({"dwell_s": 0.5}, STEP), start_in_s=1.0)
    assert progress.started_at_ns is not None
    assert progress.began_at_ns is not None
    assert progress.began_at_ns - progress.started_at_ns > 1_500_000_000
    assert {part.began_at_ns for part in parts.values()} != {None}


def test_a_question_that_was_lost_is_asked_again() -> None:
    wire = Wire(loses=lambda question: question.number == 1 and question.given["do"] != "clock")
    progress, _ = perform(
        wire, 5, ({"move": 90.0}, {"wait_until": {"axis": "m1", "field": "v", "above": 1}}, STEP)
    )
    assert (progress.state, progress.why) == ("done", None)
    assert wire.refused == []


def test_a_question_that_comes_twice_is_done_once() -> None:
    wire = Wire(copies=2)
    progress, _ = perform(wire, 5)
    assert (progress.state, progress.why) == ("done", None)


def away(from_s: float, to_s: float) -> Callable[[Question], bool]:
    return lambda question: question.to == "b1" and from_s <= question.at_s < to_s


def test_a_link_away_does_not_end_a_run_that_can_bear_it() -> None:
    for_s = 1.6  # a cut of 0.9 s, and the time until the link is used again
    far = ({"move": 3600.0},)
    assert perform(Wire(loses=away(5, 5 + for_s)), steps=far, silence_s=3.0)[0].state == "done"
    progress, parts = perform(Wire(loses=away(5, 5 + for_s)), steps=far)
    assert progress.state == "failed"
    assert progress.why is not None
    assert progress.why.startswith("the bench b1 is gone: silent for 1.")
    assert (parts["b1"].why or "").startswith("the bench b0, which leads, is gone")


def test_a_link_away_at_the_end_of_a_phrase_is_waited_for() -> None:
    steps = ({"move": 360.0}, {"wait_until": {"axis": "m1", "field": "v", "above": 1}}, {"move": 0.0})
    for begins_s in (1.0, 1.6, 1.7, 1.8, 1.9, 2.0):  # the first phrase ends at 1.7 s or so
        progress, _ = perform(Wire(loses=away(begins_s, begins_s + 1.5)), steps=steps, silence_s=3.0)
        assert (progress.state, progress.why) == ("done", None), begins_s


def test_a_figure_that_is_refused_is_seen_to_be_over() -> None:
    progress, _ = perform(Wire(way_s=lambda bench: 0.0204 if bench == "b1" else 0.001))
    assert progress.state == "failed"
    assert "the clock of b1 is known to 20.4 ms, 20 are allowed" in str(progress.why)


def test_a_bench_that_is_away_is_told_with_the_time_it_had() -> None:
    with pytest.raises(ConfigError, match=r"the bench b2 did not answer within 0\.3"):
        perform(Wire(loses=lambda question: question.to == "b2"))


def test_the_answer_to_a_question_that_was_taken_for_lost_counts() -> None:
    asked = []

    async def slow(left_s: float) -> int:
        asked.append(left_s)
        await asyncio.sleep(0.25)
        return len(asked)

    async def busy(left_s: float) -> int:
        asked.append(left_s)
        if len(asked) < 3:
            raise VerbRefused("busy", "no room")
        return len(asked)

    async def forbidden(left_s: float) -> int:
        raise VerbRefused("forbidden", "no")

    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        assert runner.run(asked_again(slow, 0.3)) == 3
        asked.clear()
        assert runner.run(asked_again(busy, 0.3)) == 3
        with pytest.raises(VerbRefused, match="no"):
            runner.run(asked_again(forbidden, 0.3))
