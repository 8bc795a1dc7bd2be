"""A SAC as an axis of a run, over its terminal: here a twin's, on the virtual clock."""

from typing import Any

import pytest

from device_profiles.sac.dialogues import RunAxis
from hil.testing import Bench
from hil.vocab.dialogue import Dialogue, DialogueError, Heard, Listen, Send
from hil.vocab.time import NS_PER_MS

SAC = {"profile": "sac"}
LEAD_NS = 250 * NS_PER_MS


def taken(baud: int = 38400) -> tuple[Bench, RunAxis]:
    bench = Bench({"bench": "b", "devices": {"s1": {"profile": "sac", "baud": baud}}})
    bench.run(2000)
    axis = RunAxis()
    bench.talk("s1", axis.acquire())
    return bench, axis


def go(bench: Bench, axis: RunAxis, position_deg: float, velocity_rpm: float = 60) -> int:
    """Command a motion, and return the time in ns at which it is to start."""
    start_ns = int(bench.now_ns) + LEAD_NS
    bench.talk("s1", axis.move_abs(position_deg, velocity_rpm, start_ns))
    return start_ns


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


def test_a_board_that_was_taken_counts_from_where_it_stands() -> None:
    bench, axis = taken()
    assert axis.commanded_deg == 0.0
    for wanted_deg, pulses in ((90.0, 100), (45.2, 50), (-1.0, -1), (-1.1, -1)):
        go(bench, axis, wanted_deg)
        assert axis.commanded_deg == pytest.approx(pulses * 0.9)
        state = bench.axis("s1").snapshot()
        assert (state.motion_state, state.commanded_deg) == (0, pytest.approx(pulses * 0.9))
    bench.talk("s1", axis.acquire())
    assert axis.commanded_deg == 0.0


def test_it_starts_at_its_time_but_for_two_characters() -> None:
    bench, axis = taken()
    clk = bench.device("s1").pin("clk")
    clk.edges()
    start_ns = go(bench, axis, 360.0)
    first_ns = next(at_ns for at_ns, level in clk.edges() if level)
    characters_ns = 2 * 10 * 10**9 // 38400
    assert characters_ns <= first_ns - start_ns <= characters_ns + NS_PER_MS


def test_microsteps_and_steps_of_a_turn_are_the_boards_own() -> None:
    bench, axis = taken()
    for line in ("$CJ4", "$Ca400"):
        bench.talk("s1", typed(line))
    bench.talk("s1", axis.acquire())
    go(bench, axis, 90.0)
    assert bench.axis("s1").snapshot().pulses == 400 * 16 // 4


def typed(line: str) -> Dialogue[None]:
    yield Send(f"{line}\r".encode())
    while not (yield Listen(NS_PER_MS * 100)).data.endswith(b">"):
        pass


@pytest.mark.parametrize("how", ["grace", "prejudice"])
@pytest.mark.parametrize("after_ms", [20, 249, 251, 1000])
def test_it_is_stopped_wherever_it_is(how: Any, after_ms: float) -> None:
    bench, axis = taken()
    begun_ns = int(bench.now_ns)
    move = axis.move_abs(3600.0, 300, begun_ns + LEAD_NS)
    bench.talk("s1", broken_off(move, begun_ns + round(after_ms * NS_PER_MS)))
    bench.talk("s1", axis.stop(how, 600.0))
    state = bench.axis("s1").snapshot()
    assert (state.motion_state, state.pending) == (0, 0)
    assert (state.pulses > 0) == (after_ms > 250)
    assert state.pulses < 2000
    assert axis.commanded_deg is None
    bench.talk("s1", axis.acquire())
    go(bench, axis, 9.0)
    assert bench.axis("s1").snapshot().pulses == state.pulses + 10


def test_a_line_that_is_too_slow_is_found_before_anything_moves() -> None:
    bench, axis = taken(baud=1200)
    with pytest.raises(DialogueError, match=r"it took its command [0-9]+ ms after the start"):
        bench.talk("s1", axis.move_abs(90.0, 60, bench.now_ns + 100 * NS_PER_MS))
    assert bench.axis("s1").snapshot().pulses == 0


def test_a_board_that_dies_is_noticed_within_one_and_a_half_seconds() -> None:
    """The run asks the board each half second, and gives it 0.8 s to answer."""
    bench, axis = taken()
    start_ns = int(bench.now_ns) + LEAD_NS
    move = axis.move_abs(3600.0, 60, start_ns)
    died_ns = start_ns + 2000 * NS_PER_MS
    with pytest.raises(DialogueError, match="no prompt"):
        bench.talk("s1", _deaf_from(move, died_ns))
    assert 0 < bench.now_ns - died_ns <= 1500 * NS_PER_MS


def _deaf_from(dialogue: Dialogue[None], at_ns: int) -> Dialogue[None]:
    """A dialogue whose board says nothing any more from then on."""
    now = yield Listen(0)
    answer: Any = None
    while True:
        step = dialogue.send(answer)
        if now.at_ns < at_ns:
            answer = yield step
        elif isinstance(step, Listen):
            end_ns = now.at_ns + step.timeout_ns
            while now.at_ns < end_ns:
                now = yield Listen(end_ns - now.at_ns)
            answer = Heard(now.at_ns, b"")
        else:
            answer = yield step
        now = answer or now


def test_one_release_starts_others_over_a_wire() -> None:
    """OP SB falls with the first pulse: at another one's sync it releases what a run holds there."""
    wires = [{"from": "s1.OP_SB", "to": "s2.sync"}]
    bench = Bench({"bench": "b", "devices": {"s1": SAC, "s2": SAC}, "wires": wires})
    bench.run(2000)
    for name in ("s1", "s2"):
        bench.port(name).write(b"xm100v60u0ps\r")
        bench.device(name).pin("clk").edges()
    bench.run(100)
    bench.port("s1").write(b"y\r")
    bench.run(100)
    first, second = (
        next(at_ns for at_ns, level in bench.device(name).pin("clk").edges() if level)
        for name in ("s1", "s2")
    )
    assert 0 <= second - first <= 100_000
    bench.port("s2").write(b"y\r")
    bench.run(3000)
    assert [bench.axis(name).snapshot().pulses for name in ("s1", "s2")] == [100, 100]


def test_a_board_that_never_comes_to_its_end_is_given_up() -> None:
    """Let a packet make the board turn forever."""
    bench, axis = taken()
    begun_ns = int(bench.now_ns)
    move = axis.move_abs(36.0, 60, begun_ns + LEAD_NS)

    def disturbed() -> Dialogue[None]:
        answer: Any = None
        is_disturbed = False
        while True:
            if not is_disturbed and bench.axis("s1").snapshot().pulses > 10:
                is_disturbed = True
                bench.axis("s1").do("velocity", velocity_rpm=30)
            try:
                answer = yield move.send(answer)
            except StopIteration:
                return

    with pytest.raises(DialogueError, match="does not come to its end"):
        bench.talk("s1", disturbed())
    slowest_s = 36.0 / 360 * 60 / 10
    assert slowest_s + 10 < (bench.now_ns - begun_ns) / 1e9 < slowest_s + 11
    bench.talk("s1", axis.stop("grace", 0.0))
    assert bench.axis("s1").snapshot().motion_state == 0
