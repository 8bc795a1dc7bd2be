"""A Mechaduino as an axis of a run, over its menu: here a twin's, on the virtual clock."""

from typing import Any

import pytest

from device_profiles.mechaduino.dialogues import RunAxis
from hil.firmware.set_point_paths import at, length_ns, trapezoid
from hil.testing import Bench
from hil.testing.bench_dialogue import LISTEN_SLICE_NS
from hil.vocab.dialogue import Dialogue, DialogueError, Heard, Listen, Send
from hil.vocab.path import DEG_PER_S, Path
from hil.vocab.time import NS_PER_MS

PERIOD_NS = 20 * NS_PER_MS
WAY: Path = trapezoid(0.0, 0.0, 181.2345, 60 * DEG_PER_S, 600 * DEG_PER_S)


def taken(*typed: bytes) -> tuple[Bench, RunAxis]:
    bench = Bench(
        {"bench": "b", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}
    )
    bench.run(4100)
    for text in typed:
        bench.port("m1").write(text)
        bench.run(50)
    axis = RunAxis()
    bench.talk("m1", axis.acquire())
    return bench, axis


def from_zero(bench: Bench, axis: RunAxis) -> None:
    here = axis.commanded_deg or 0.0
    way = trapezoid(here, 0.0, 0.0, 360.0, 3600.0)
    bench.talk("m1", axis.follow(way, int(bench.now_ns), PERIOD_NS))
    bench.run(200)


@pytest.mark.parametrize("typed", [(), (b"vy",), (b"xy", b"r20\n"), (b"n",)])
def test_it_is_taken_where_it_stands_and_holds(typed: tuple[bytes, ...]) -> None:
    bench, axis = taken(*typed)
    state = bench.axis("m1").snapshot()
    assert (state.loop_on, chr(state.mode)) == (1, "x")
    assert axis.commanded_deg == pytest.approx(state.r, abs=0.006)
    bench.run(200)
    assert bench.axis("m1").snapshot().yw == pytest.approx(state.r, abs=0.2)


def test_a_path_is_typed_at_its_rate_and_ends_exactly() -> None:
    bench, axis = taken()
    from_zero(bench, axis)
    start_ns = int(bench.now_ns) + 100 * NS_PER_MS
    recording = bench.axis("m1").record("r", "yw", interval_ms=1)
    bench.talk("m1", axis.follow(WAY, start_ns, PERIOD_NS))
    assert axis.commanded_deg == 181.234
    assert bench.axis("m1").snapshot().r == pytest.approx(181.234, abs=1e-4)
    took_ns = bench.now_ns - start_ns
    assert 0 <= took_ns - length_ns(WAY) <= 2 * LISTEN_SLICE_NS
    rows = [(int(at_ns), r) for at_ns, r, _ in recording.rows]
    values = {r for at_ns, r in rows if start_ns <= at_ns}
    assert len(values) == pytest.approx(length_ns(WAY) / PERIOD_NS, abs=3)
    behind = [at(WAY, at_ns - start_ns)[0] - r for at_ns, r in rows if at_ns >= start_ns]
    step_deg = 360.0 * PERIOD_NS / 1e9
    assert 0.8 * step_deg < max(behind) < 1.2 * step_deg


@pytest.mark.parametrize("how", ["grace", "prejudice"])
@pytest.mark.parametrize("after_ms", [10, 300, 301, 305, 320])
def test_it_is_stopped_on_its_way(how: Any, after_ms: int) -> None:
    bench, axis = taken()
    from_zero(bench, axis)
    start_ns = int(bench.now_ns) + 50 * NS_PER_MS
    bench.talk("m1", broken_off(axis.follow(WAY, start_ns, PERIOD_NS), start_ns + after_ms * NS_PER_MS))
    before = bench.axis("m1").snapshot().r
    bench.talk("m1", axis.stop(how, 600.0))
    state = bench.axis("m1").snapshot()
    assert axis.commanded_deg == pytest.approx(state.r, abs=0.001)
    ramp_deg = 360.0**2 / (2 * 3600) if how == "grace" and after_ms > 100 else 0.0
    assert state.r - before == pytest.approx(ramp_deg, abs=0.6)


def broken_off(dialogue: Dialogue[None], at_ns: int) -> Dialogue[None]:
    """The beginning of a dialogue, up to a time."""
    now = yield Listen(0)
    answer: Any = None
    while now.at_ns < at_ns:
        step = dialogue.send(answer)
        if isinstance(step, Listen):
            step = Listen(min(step.timeout_ns, at_ns - now.at_ns))
        answer = yield step
        now = answer or now
    dialogue.close()


def with_answers(dialogue: Dialogue[None], answers: list[bytes]) -> None:
    """Carry a dialogue out with a board that says these, one after each Send."""
    answer: Any = None
    now_ns, waiting = 0, b""
    try:
        while True:
            step = dialogue.send(answer)
            answer = None
            if isinstance(step, Send):
                waiting = answers.pop(0)
            elif isinstance(step, Listen):
                now_ns += 1 if waiting else step.timeout_ns
                answer, waiting = Heard(now_ns, waiting), b""  # type: ignore[arg-type]
    except StopIteration:
        return


@pytest.mark.parametrize(
    ("answers", "said"),
    [
        ([b"New setpoint 0.00\r\n", b""], '"r0.000" was not answered'),
        (
            [b"New setpoint 0.00\r\n", b"Enter setpoint:\r\n7.00\r\n"],
            "was taken as 7.0: characters were lost",
        ),
        ([b"New setpoint nan\r\n"], '"y" was not answered'),
        ([b""], '"y" was not answered'),
    ],
)
def test_what_a_board_does_not_confirm_is_an_error(answers: list[bytes], said: str) -> None:
    axis = RunAxis()

    def both() -> Dialogue[None]:
        yield from axis.acquire()
        yield from axis.follow(WAY, 10**12, PERIOD_NS)

    with pytest.raises(DialogueError, match=said):
        with_answers(both(), answers)
    assert axis.commanded_deg is None
