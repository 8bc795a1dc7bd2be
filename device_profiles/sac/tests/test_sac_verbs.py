"""Verbs of a SAC beside typing: each moves as its command does, pulse for pulse."""

from collections.abc import Iterator
from typing import Any

import pytest

from hil.core import Snapshot
from hil.testing import Bench
from hil.vocab.verbs import VerbRefused

CONFIG: dict[str, Any] = {"bench": "t", "devices": {"s1": {"profile": "sac", "port": "memory"}}}
PULSE_DEG = 0.9
"""200 steps a turn, 2 pulses a step: the factory's settings."""


class Board:
    """A board past its cold start."""

    def __init__(self, *typed: str) -> None:
        self.bench = Bench(CONFIG)
        self.port = self.bench.port("s1")
        self.axis = self.bench.axis("s1")
        self.device = self.bench.device("s1")
        self.bench.run(1500)
        for line in typed:
            self.type(line)

    def type(self, line: str) -> str:
        self.port.read()
        self.port.write(line.encode() + b"\r")
        self.run(100)
        return self.port.read().decode()

    def run(self, ms: float) -> Snapshot:
        self.bench.run(ms)
        assert self.device.failed is None
        return self.now

    @property
    def now(self) -> Snapshot:
        return self.axis.snapshot()

    def do(self, verb: str, **parameters: float | str) -> dict[str, Any]:
        return self.axis.do(verb, **parameters)

    def refusal(self, verb: str, **parameters: float | str) -> tuple[str, str]:
        before = self.now
        with pytest.raises(VerbRefused) as refused:
            self.do(verb, **parameters)
        assert self.now == before
        said = str(refused.value).removeprefix("s1: ")
        return refused.value.code, said.removesuffix("; b.start() lets it start")

    def stands(self) -> Snapshot:
        """Let the board come to an end of its motion."""
        for _ in range(600):
            if self.run(100).motion_state == 0:
                return self.run(1000)
        raise AssertionError("it did not come to an end")

    def pulses(self) -> list[tuple[int, str, int]]:
        """Edges of clock and direction since the first of the clock: (ns after it, pin, level)."""
        edges = [
            (at_ns, name, level) for name in ("clk", "dir") for at_ns, level in self.device.pin(name).edges()
        ]
        edges.sort()
        first_ns = next(at_ns for at_ns, name, _ in edges if name == "clk")
        return [(at_ns - first_ns, name, level) for at_ns, name, level in edges if at_ns >= first_ns]


@pytest.fixture
def board() -> Iterator[Board]:
    made = Board()
    yield made
    made.bench.close()


def same_pulses(verb: str, parameters: dict[str, Any], typed: str, *before: str) -> None:
    """Check that a verb's pulses are those of a typed line, in its first three seconds at least."""
    asked, typing = Board(*before), Board(*before)
    asked.do(verb, **parameters)
    typing.port.write(typed.encode() + b"\r")
    for each in (asked, typing):
        each.run(3500)
    pulses = [[edge for edge in each.pulses() if edge[0] < 3_000_000_000] for each in (asked, typing)]
    assert pulses[0] == pulses[1] != []
    assert (asked.now.pulses > 0) == (typing.now.pulses > 0)


@pytest.mark.parametrize(
    ("verb", "parameters", "typed"),
    [
        ("move_rel", {"angle_deg": 180.0}, "xm200p"),
        ("move_rel", {"angle_deg": -90.0}, "xm-100p"),
        ("move_rel", {"angle_deg": 360.0, "velocity_rpm": 120}, "xm400v120p"),
        (
            "move_rel",
            {"angle_deg": 360.0, "velocity_rpm": 150, "acceleration": 3.25, "deceleration": 8},
            "xm400v150a3.25d8p",
        ),
        ("move_rel", {"angle_deg": 90.0, "acceleration": 0, "deceleration": 0}, "xm100a0d0p"),
        ("move_rel", {"angle_deg": 90.0, "acceleration": 998}, "xm100a998p"),
        ("move_abs", {"position_deg": -45.0, "velocity_rpm": 30}, "xm-50v30p"),
        ("run", {"position": 3}, "x3"),
        ("loop", {"first": 1, "last": 2, "passes": 2}, "ln2\rls1\rlf2"),
    ],
)
def test_a_verb_makes_the_pulses_of_its_command(verb: str, parameters: dict[str, Any], typed: str) -> None:
    entries = ("q1m20v60", "q2m-10v80", "q3m30v100a2")
    same_pulses(verb, parameters, typed, *entries)


@pytest.mark.parametrize(
    ("rpm", "typed"), [(60, "xm0v60"), (-200, "xm-0v200"), (1, "xm0v1"), (2000, "xm0v2000")]
)
def test_a_speed_makes_the_pulses_of_the_continuous_command(rpm: int, typed: str) -> None:
    same_pulses("velocity", {"velocity_rpm": rpm}, typed)


@pytest.mark.parametrize("level", [0, 1])
def test_positive_is_clockwise_whatever_the_default_direction(level: int) -> None:
    board = Board(f"$CG{level}", "$R")
    board.do("velocity", velocity_rpm=60)
    assert board.run(500).pulses > 0
    board.do("stop", how="prejudice")
    board.do("velocity", velocity_rpm=-60)
    before = board.now.pulses
    assert board.run(500).pulses < before
    board.do("stop", how="prejudice")
    before = board.now.pulses
    board.do("move_rel", angle_deg=9.0)
    assert board.stands().pulses == before + 10
    board.do("queue", position=1, steps=7)
    board.do("run", position=1)
    assert board.stands().pulses == before + 24


# ---- angles ----


def test_angles_are_exact_and_absolute(board: Board) -> None:
    for position_deg in (90.0, -33.3, 720.9, 0.0, 0.0, 45.0):
        answer = board.do("move_abs", position_deg=position_deg, velocity_rpm=200)
        pulses = round(position_deg / PULSE_DEG)
        state = board.stands()
        assert state.commanded_deg == pytest.approx(pulses * PULSE_DEG, abs=1e-9)
        assert state.pulses == pulses
        assert answer["angle_deg"] == pytest.approx(answer["pulses"] * PULSE_DEG)
        assert answer["set_point"] == pytest.approx(state.commanded_deg, abs=1e-9)
        assert abs(state.position_deg - board.now.commanded_deg) < 1.0


def test_where_it_goes_is_not_told_of_a_move_that_begins_while_it_moves(board: Board) -> None:
    assert "set_point" in board.do("move_rel", angle_deg=3600.0)
    board.run(50)
    assert "set_point" not in board.do("move_rel", angle_deg=-90.0)


def test_attributes_of_earlier_commands_add_no_pulses(board: Board) -> None:
    board.type("m10u7")
    before = board.stands().pulses
    board.do("move_rel", angle_deg=3600.0)
    assert board.stands().pulses == before + 4000
    board.type("$P")  # steps are pulses from now on
    board.do("move_rel", angle_deg=-3600.0)
    assert board.stands().pulses == before


def test_microsteps_count(board: Board) -> None:
    board.type("$CJ4")
    board.type("$R")
    assert board.do("move_rel", angle_deg=9.0)["pulses"] == 80
    assert board.stands().commanded_deg == pytest.approx(9.0)


def test_less_than_half_a_pulse_is_no_motion(board: Board) -> None:
    assert board.do("move_rel", angle_deg=0.4) == {
        "pulses": 0,
        "angle_deg": 0.0,
        "set_point": 0.0,
        "effective_at_ns": board.bench.now_ns,
    }
    assert board.now.motion_state == 0
    assert board.run(500).pulses == 0


def test_an_absolute_move_needs_a_standing_motor(board: Board) -> None:
    board.do("move_rel", angle_deg=720.0)
    board.run(300)
    assert board.refusal("move_abs", position_deg=0.0) == (
        "not_now",
        "it moves, and where it will be is not known; stop it first",
    )
    state = board.stands()
    assert state.commanded_deg == 720.0
    board.do("move_abs", position_deg=0.0)
    assert board.stands().pulses == 0


# ---- speeds ----


def test_a_speed_changes_in_the_same_direction_without_a_stop(board: Board) -> None:
    board.do("velocity", velocity_rpm=60)
    assert board.run(3000).speed_rpm == 60
    board.do("velocity", velocity_rpm=150)
    seen = [board.run(20).speed_rpm for _ in range(150)]
    assert min(seen) >= 60
    assert seen[-1] == 150
    board.do("velocity", velocity_rpm=90)
    assert board.run(3000).speed_rpm == 90


def test_a_speed_that_turns_round(board: Board) -> None:
    board.do("velocity", velocity_rpm=60)
    before = board.run(2000)
    board.do("velocity", velocity_rpm=-60)
    after = board.run(4000)
    assert after.speed_rpm == 60
    assert board.run(1000).pulses == pytest.approx(after.pulses - 400, abs=2)
    assert after.pulses < before.pulses + 400


def test_no_speed_stops_with_grace(board: Board) -> None:
    board.do("velocity", velocity_rpm=150)
    board.run(3000)
    board.do("velocity", velocity_rpm=0)
    assert board.run(10).motion_state == 3
    assert board.stands().motion_state == 0


@pytest.mark.parametrize("rpm", [60, 150, 190])
def test_a_speed_while_it_stops_is_not_lost(board: Board, rpm: int) -> None:
    board.do("velocity", velocity_rpm=150)
    board.run(3000)
    board.do("stop")
    board.run(50)
    assert board.now.motion_state == 3
    board.do("velocity", velocity_rpm=rpm)
    assert board.run(6000).speed_rpm == rpm


@pytest.mark.parametrize(
    "rpms", [(60, 90), (-60, -90), (-60, 60), (-60, 90), (-60, 0, 30), (0, 60), (0, -60)]
)
def test_of_speeds_at_one_moment_the_last_one_counts(board: Board, rpms: tuple[int, ...]) -> None:
    board.do("velocity", velocity_rpm=60)
    board.run(2000)
    for rpm in rpms:
        board.do("velocity", velocity_rpm=rpm)
    before = board.run(6000)
    assert before.speed_rpm == abs(rpms[-1])
    assert (board.run(500).pulses > before.pulses) == (rpms[-1] > 0)


def test_a_speed_after_a_move(board: Board) -> None:
    board.do("move_rel", angle_deg=3600.0, velocity_rpm=100)
    board.run(1000)
    board.do("velocity", velocity_rpm=50)
    assert board.run(5000).speed_rpm == 50
    assert board.now.queue_position == 0


# ---- the queue ----


def test_queue_is_the_queues_edit(board: Board) -> None:
    typing = Board("q4m-250v80a2.5d3s1f")
    board.do("queue", position=4, steps=-250, velocity_rpm=80, acceleration=2.5, deceleration=3, sync=1)
    assert board.type("q") == typing.type("q")


def test_steps_of_the_queue_are_full_steps_always(board: Board) -> None:
    board.type("q5m10p")
    board.do("queue", position=5, steps=10)
    board.do("run", position=5)
    assert board.stands().pulses == 20


def test_an_entry_waits_for_the_sync(board: Board) -> None:
    board.do("queue", position=1, steps=25, sync=1)
    board.do("run", position=1)
    assert board.run(1000).pulses == 0
    board.do("sync")
    assert board.stands().pulses == 50
    board.do("queue", position=1, steps=25, sync=0)
    board.do("run", position=1)
    assert board.stands().pulses == 100


def test_a_loop_for_ever_ends_with_stop(board: Board) -> None:
    board.do("queue", position=2, steps=20)
    board.do("queue", position=3, steps=-10)
    board.do("loop", first=2, last=3, passes=0)
    assert board.run(20_000).pulses > 100
    board.do("stop", how="prejudice")
    state = board.now
    assert state.motion_state == 0
    assert board.run(3000).pulses == state.pulses


def test_a_loop_backwards_is_refused(board: Board) -> None:
    assert board.refusal("loop", first=4, last=3) == (
        "bad_parameter",
        "last: 3 comes before first, 4",
    )
    assert board.refusal("run", position=31) == ("bad_parameter", "position: 31 is too large; write 1 to 30")


def test_single_pulses_while_it_stands(board: Board) -> None:
    for _ in range(3):
        board.do("pulse", direction="ccw")
        board.run(10)
    board.do("pulse")
    assert board.run(10).pulses == -2


@pytest.mark.parametrize(("how", "typed"), [("grace", "s"), ("prejudice", "S")])
def test_stop_is_as_the_letter(how: str, typed: str) -> None:
    boards = Board(), Board()
    for each in boards:
        each.do("move_rel", angle_deg=3600.0, velocity_rpm=150)
        each.run(2000)
    boards[0].do("stop", how=how)
    boards[1].port.write(typed.encode() + b"\r")
    ends = [each.stands().pulses for each in boards]
    # The line takes the time of its characters.
    assert ends[0] <= ends[1] <= ends[0] + 3


def test_nothing_is_done_during_the_cold_start() -> None:
    bench = Bench(CONFIG)
    bench.run(500)
    for verb, parameters in (("velocity", {"velocity_rpm": 60}), ("pulse", {}), ("stop", {})):
        with pytest.raises(VerbRefused, match="it is starting") as refused:
            bench.axis("s1").do(verb, **parameters)
        assert refused.value.code == "not_now"
    bench.run(600)
    bench.axis("s1").do("velocity", velocity_rpm=60)
    bench.run(3000)
    assert bench.axis("s1").snapshot().speed_rpm == 60


def test_an_absolute_move_is_refused_while_something_waits_to_move(board: Board) -> None:
    board.do("loop", first=1, last=2, passes=1)
    assert board.refusal("move_abs", position_deg=0.0)[0] == "not_now"
    board.do("stop", how="prejudice")
    board.type("m10s")
    assert board.now.is_held == 1
    assert board.refusal("move_abs", position_deg=0.0)[0] == "not_now"
    board.do("stop")
    board.do("move_abs", position_deg=45.0)
    assert board.stands().pulses == 50


def test_of_two_moves_at_one_moment_the_second_is_made(board: Board) -> None:
    # As of two xm: the one preempts the other.
    board.do("move_rel", angle_deg=90.0)
    board.do("move_rel", angle_deg=-45.0)
    assert board.stands().pulses == -50
    board.do("move_rel", angle_deg=90.0)
    board.do("move_abs", position_deg=9.0)
    assert board.stands().pulses == 10
