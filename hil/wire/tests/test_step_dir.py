"""Pulse trains: generated ones end where they should, files are read to the letter, bad ones refused."""

import itertools
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.wire.step_dir import (
    MAX_NS,
    MAX_RAMP_STEPS,
    MAX_ROWS,
    MAX_STEPS,
    Edges,
    TrainError,
    generate,
    parse_train,
    train_length_ns,
    train_problem,
)


def rises(train: tuple[Edges, ...]) -> list[int]:
    return [
        e.at_ns + 2 * j * e.duration_ns // (2 * e.steps) for e in train if e.steps for j in range(e.steps)
    ]


@given(
    st.integers(1, 5000),
    st.floats(1, 200_000),
    st.one_of(st.none(), st.floats(1, 1e8)),
)
def test_a_train_has_its_steps_in_order_and_never_exceeds_its_rate(
    steps: int, rate_hz: float, acceleration: float | None
) -> None:
    train = generate(-steps, rate_hz, acceleration)
    assert train[0] == Edges(0, pin="dir", level=1)
    assert sum(e.steps for e in train) == steps
    times = rises(train)
    assert times == sorted(set(times))
    assert all(e.at_ns >= p.end_ns for p, e in itertools.pairwise(train))
    # A step may be 1 ns short: ends are rounded one by one.
    assert min((b - a for a, b in itertools.pairwise(times)), default=1e9) >= 1e9 / rate_hz - 2


def test_a_ramp_is_that_of_constant_acceleration() -> None:
    train = generate(2000, 10_000, 50_000)  # v2 / 2a = 1000 steps up, 1000 down
    times = rises(train)
    for k in (1, 10, 500, 999):
        assert times[k] == pytest.approx((2 * k / 50_000) ** 0.5 * 1e9, abs=2)
    assert train_length_ns(train) == pytest.approx(0.4e9, abs=100)


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        ((0, 1000.0), "0 steps"),
        ((10, 0.0), "a rate of 0"),
        ((10, float("nan")), "a rate of nan"),
        ((10, 200_001.0), "a rate of 200001"),
        ((10, 100.0, -1.0), "an acceleration of -1"),
        ((10, 100.0, float("inf")), "an acceleration of inf"),
        ((100_000_000, 1e-9), "a rate of 1e-9"),
    ],
)
def test_what_cannot_be_generated_is_refused(arguments: tuple[float, ...], what: str) -> None:
    with pytest.raises(TrainError, match=what):
        generate(*arguments)  # type: ignore[arg-type]


def test_levels_of_a_logic_analyser() -> None:
    text = "Time [s],STEP,Dir\n0,0,1\n0.001,1,1\n0.0010005,0,1\n0.002,1,0\n"
    assert parse_train(text, "t.csv") == (
        Edges(0, "dir", 1),
        Edges(0, "step", 0),
        Edges(1_000_000, "step", 1),
        Edges(1_000_500, "step", 0),
        Edges(2_000_000, "dir", 0),
        Edges(2_000_000, "step", 1),
    )


def test_runs() -> None:
    text = "at_s,steps,duration_s\n0,3,0.3\n0.3,-2,0.00001\n"
    assert parse_train(text, "t.csv") == (
        Edges(0, "dir", 0),
        Edges(0, steps=3, duration_ns=300_000_000),
        Edges(300_000_000, "dir", 1),
        Edges(300_000_000, steps=2, duration_ns=10_000),
    )


@given(st.lists(st.tuples(st.integers(0, 10**9), st.integers(0, 1), st.integers(0, 1)), max_size=30))
def test_any_sorted_levels_are_read_back(rows: list[tuple[int, int, int]]) -> None:
    rows.sort()
    text = "at_s,step,dir\n" + "".join(f"{Decimal(t).scaleb(-9)},{s},{d}\n" for t, s, d in rows)
    levels: dict[str, int] = {}
    for edges in parse_train(text, "t.csv"):
        assert levels.get(edges.pin) != edges.level
        levels[edges.pin] = edges.level
    assert levels == ({"step": rows[-1][1], "dir": rows[-1][2]} if rows else {})


def test_every_bad_row_is_listed_with_its_line() -> None:
    rows = ["0,1,1", "0.5,1,1", "2,0,1", "3,x,1", "4,1", "5,10,0.000000019", "6,1.5,1", "-7,1,1", "8,1,1e30"]
    text = "\n".join(["at_s,steps,duration_s", *rows])
    with pytest.raises(TrainError) as caught:
        parse_train(text, "t.csv")
    lines = str(caught.value).splitlines()
    assert [line.split(":")[1] for line in lines] == ["3", "4", "5", "6", "7", "8", "9", "10"]
    assert "sort the rows" in lines[0]


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "at_s\n1\n", "at_s,steps\n1,1\n", "at_s,step,led\n"])
def test_a_header_that_says_nothing_known_is_refused(text: str) -> None:
    with pytest.raises(TrainError, match=r"^t.csv:1:1: .*; ?write|^t.csv:1:1: .*write"):
        parse_train(text, "t.csv")


@given(st.text(max_size=200))
def test_any_text_is_read_or_refused(text: str) -> None:
    refusal = ""
    try:
        parse_train("at_s,step,dir\n" + text, "t.csv")
    except TrainError as error:
        refusal = str(error)
    assert all(line.startswith("t.csv:") for line in refusal.split("\n") if line)


@pytest.mark.parametrize(
    ("steps", "duration_s", "why"),
    [
        (1_000_000_000, "2", "write at most 100,000,000 in a row"),
        (-1_000_000_000, "5000", "write at most 100,000,000 in a row"),
        (100_000_000, "499", "at 200,000 Hz they take 500000000000 ns"),
        (1000, "0.000002", "at 200,000 Hz they take 5000000 ns"),
        (1, "0.0000049", "at 200,000 Hz they take 5000 ns"),
    ],
)
def test_a_run_is_no_faster_and_no_longer_than_a_board_sees(steps: int, duration_s: str, why: str) -> None:
    with pytest.raises(TrainError, match=why):
        parse_train(f"at_s,steps,duration_s\n0,{steps},{duration_s}\n", "t.csv")
    problem = train_problem([Edges(0, steps=abs(steps), duration_ns=int(Decimal(duration_s) * 10**9))])
    assert problem
    assert why in problem


def test_the_fastest_and_longest_run_is_taken() -> None:
    fastest = Edges(0, steps=MAX_STEPS, duration_ns=MAX_STEPS * 5000)
    assert parse_train(f"at_s,steps,duration_s\n0,{MAX_STEPS},500\n", "t.csv")[1] == fastest
    assert train_problem([fastest, Edges(fastest.end_ns, steps=1, duration_ns=MAX_NS)]) is None
    assert train_problem([Edges(0, steps=1, duration_ns=MAX_NS + 1)])


@given(
    st.integers(1, 100_000),
    st.integers(1, 200_000),
    st.none() | st.integers(3, 12).map(lambda power: 10.0**power),
)
def test_what_is_generated_is_no_problem(steps: int, rate_hz: float, acceleration: float | None) -> None:
    assert train_problem(generate(steps, rate_hz, acceleration)) is None


def test_a_ramp_has_so_many_rows() -> None:
    # v^2 / 2a is as long as a ramp may be, and a bit
    longest = generate(MAX_STEPS, 200_000, 200_000**2 / (2 * MAX_RAMP_STEPS + 1))
    assert len(longest) == MAX_ROWS
    with pytest.raises(TrainError, match="write an acceleration that reaches the rate in 99,999"):
        generate(MAX_STEPS, 200_000, 0.001)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("at_s;steps;duration_s\n0;1;0,5\n", 't.csv:1:5: columns are separated by ";"; write commas there'),
        ("at_s\tstep\n0\t1\n", "t.csv:1:5: columns are separated by a tab; write commas there"),
        ("time,stp\n0,1\n", "t.csv:1:1: the header is time,stp; write at_s,steps,duration_s"),
        ("at_s,step\n0.1, high\n", "t.csv:2:6: 'high' is not a number; write one"),
        (
            "at_s,steps,duration_s\n0,9,0.5\n0.1,9,0.5\n",
            "t.csv:3:1: begins before .*, at 0.5 s; write 0.5 or",
        ),
    ],
)
def test_a_mistake_of_a_file_has_its_place_and_what_to_write(text: str, said: str) -> None:
    with pytest.raises(TrainError, match=f"^{said}"):
        parse_train(text, "t.csv")
