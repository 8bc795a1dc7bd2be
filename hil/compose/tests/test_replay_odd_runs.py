"""Runs with odd numbers on every kind of axis: refused as they are submitted, each with its place, or done.
Then a replay of the log is identical.

``HIL_FUZZ`` sets how many random runs are tried (40), ``HIL_FUZZ_SEED`` where they start.
"""

import io
import os
import random
from contextlib import suppress
from functools import cache
from typing import Any

import pytest

from hil.compose import find_catalogue, start_memories
from hil.compose.replay import MemoryOptions, replay_log
from hil.config import ConfigError, from_dict
from hil.runs import Execution
from hil.sim.bench import BenchHooks, BenchRuntime
from hil.sim.input_check import assert_taken_back
from hil.sim.input_log import InputLogWriter
from hil.sim.log_reading import read_input_log
from hil.testing import Bench
from hil.vocab.verbs import VerbRefused

CASES = int(os.environ.get("HIL_FUZZ", "40"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
CONFIG: dict[str, Any] = {
    "bench": "odd",
    "devices": {
        "s1": {"profile": "sac", "port": "memory"},
        "m1": {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}},
        "x1": {"profile": "modbus_drive"},
        "c1": {"profile": "canopen_drive"},
        "arm": {"profile": "walter"},
    },
}
AXES = ("s1", "m1", "x1", "c1", "arm.forearm", "arm.wrist")
READY_MS = 4200
MOST_MS = 2000
"""Time after which a run is cancelled."""
SPEEDS = (5e-324, 1e-9, 0.001, 0.01, 0.5, 1, 1.5, 5, 40, 40.001, 100.5, 2000, 2000.5, 3000)
STEEP = (5e-324, 1e-9, 0.001, 0.005, 0.01, 0.5, 1, 600, 1e5, 1e6)
ANGLES = (0, 5e-324, -1e-9, 0.01, 1, -30, 90, 359.9, 360.1, 1000, -1e5, 1e6)
TIMES_S = (0, 5e-324, 1e-9, 0.001, 0.3, 60, 600, 86400)
PACES = (0, 5e-324, 1e-9, 0.001, 0.3, 1)


@cache
def catalogue() -> Any:
    return find_catalogue({"memory": MemoryOptions})


@pytest.fixture(autouse=True)
def _checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(BenchRuntime, "check_input", staticmethod(assert_taken_back))


class Odd:
    """A bench with a log, whose axes are ready for runs."""

    def __init__(self) -> None:
        self.text = io.StringIO()
        memories = start_memories(from_dict(CONFIG, catalogue()), catalogue())
        self.log = InputLogWriter(self.text, "odd", CONFIG, memories)
        self.bench = Bench(CONFIG, around=BenchHooks(log=self.log))
        self.bench.run(READY_MS)
        for text in (b"POWER on\r", b"ENABLE\r"):
            self.bench.port("arm").write(text)
            self.bench.run(300)
        for name in ("m1", "x1", "c1"):
            self.bench.axis(name).do("enable")
        self.bench.run(200)

    def drive(self, execution: Execution, paces: list[float], how: Any) -> None:
        """Drive a run; its pace changes, and it is stopped if it does not end."""
        begun_ns = self.bench.now_ns
        paces = list(paces)
        for until_ns in execution.run():
            gone_ms = (self.bench.now_ns - begun_ns) / 1e6
            if paces and gone_ms > 100:
                with suppress(VerbRefused):
                    execution.set_pace(paces.pop())
            if gone_ms > MOST_MS:
                execution.stop(how)
            if gone_ms > 2 * MOST_MS:
                execution.stop("prejudice")
            if gone_ms > 6 * MOST_MS:
                break  # it cannot stop: an axis that stops by hardly anything
            self.bench.run_until(until_ns / 1e6)
        assert "error of hil" not in (execution.progress.why or "")

    def end(self) -> None:
        self.log.end()
        again = replay_log(read_input_log(io.StringIO(self.text.getvalue()), "odd.log"))
        assert again.difference() is None
        assert not again.logged.cut


def document(axes: dict[str, Any], steps: list[Any], **top: Any) -> dict[str, Any]:
    return {"run": "r", "axes": axes, "steps": steps} | top


@pytest.fixture(scope="module")
def planned() -> Bench:
    """A bench on which runs are only planned."""
    return Odd().bench


def refusal(bench: Bench, text: str) -> str:
    with pytest.raises(ConfigError) as caught:
        bench.execute(text)
    return str(caught.value)


def test_each_number_beyond_a_board_is_refused_with_its_place(planned: Bench) -> None:
    said = refusal(
        planned,
        """\
run: r
axes:
  s1: {velocity_rpm: 2500}
  arm.forearm:
    velocity_rpm: 60
  x1: {acceleration_rpm_per_s: 0.5}
  m1: {velocity_rpm: 3000}
steps:
  - move: {arm.forearm: 1000, s1: 90}
  - move: {m1: 90}
""",
    )
    lines = said.splitlines()
    assert [line for line in lines if line.startswith("<run>:3:22: ") and "1 to 2000 rpm" in line]
    assert [line for line in lines if line.startswith("<run>:5:19: ") and "0.01 to 40 rpm" in line]
    assert [line for line in lines if line.startswith("<run>:6:32: ") and "1 to 1000000 rpm/s" in line]
    assert [line for line in lines if line.startswith("<run>:9:25: ") and "-360 to 360" in line]
    assert len(lines) == 4, said


def test_a_speed_that_nobody_chose_is_one_of_the_board(planned: Bench) -> None:
    execution = planned.execute(
        document({"arm.forearm": {}, "s1": {}}, [{"move": {"arm.forearm": 20, "s1": 9}}])
    )
    (phrase,) = execution.plan.phrases
    assert [event.velocity_rpm for event in phrase.events] == [5.0, 60]  # type: ignore[union-attr]


def test_a_slow_joint_takes_as_long_as_the_others(planned: Bench) -> None:
    rules = {"velocity_rpm": 5}
    execution = planned.execute(document({"arm.forearm": rules}, [{"move": {"arm.forearm": 12}, "in_s": 4}]))
    assert execution.plan.phrases[0].events[0].velocity_rpm == pytest.approx(0.5, abs=0.01)  # type: ignore[union-attr]


def test_a_joint_at_its_default_speed_replays_identically() -> None:
    odd = Odd()
    progress = odd.bench.perform(document({"arm.forearm": {}}, [{"move": {"arm.forearm": 20}}]))
    assert progress.state == "done"
    odd.end()


def test_a_pace_that_is_hardly_any_is_refused(planned: Bench) -> None:
    execution = planned.execute(document({"m1": {}}, [{"move": {"m1": 20}}]))
    with pytest.raises(VerbRefused, match=r"0, or 0\.001 to 1"):
        execution.set_pace(5e-324)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(SEED, SEED + CASES))
def test_any_run_is_refused_or_replayed(seed: int) -> None:
    chance = random.Random(seed)
    odd = Odd()
    for number in range(6):
        names = chance.sample(AXES, chance.choice((1, 1, 2)))
        rules = {
            "velocity_rpm": SPEEDS,
            "acceleration_rpm_per_s": STEEP,
            "jerk_rpm_per_s2": (5e-324, 1e-3, 12_000, 1e9),
        }
        axes = {
            name: {key: float(chance.choice(these)) for key, these in rules.items() if chance.random() < 0.6}
            for name in names
        }
        steps: list[Any] = []
        for _ in range(chance.choice((1, 1, 3))):
            kind = chance.choice(("move", "move", "move_by", "line", "line_by", "dwell_s"))
            if kind == "dwell_s":
                steps.append({kind: float(chance.choice((5e-324, 0.01, 0.5)))})
                continue
            step: dict[str, Any] = {kind: {name: float(chance.choice(ANGLES)) for name in names}}
            if chance.random() < 0.4:
                step["in_s"] = float(chance.choice(TIMES_S))
            steps.append(step)
        shape = chance.choice(("trapezoid", "s_curve"))
        try:
            execution = odd.bench.execute(document(axes, steps, run=f"r{number}", profile=shape))
        except ConfigError:
            continue
        paces = chance.sample(PACES, 2) if chance.random() < 0.5 else []
        odd.drive(execution, paces, chance.choice(("grace", "prejudice")))
        odd.bench.run(50)
    odd.end()
