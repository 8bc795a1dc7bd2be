"""`hil top`: plots in braille, and frames that fit every terminal."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.cli.bench.braille_plot import drawn
from hil.cli.bench.top_view import KEYS, NS, Plot, TopState
from hil.cli.tests.test_axis_views import SERVO, status

NAME = "spindle_of_the_machine_in_the_left_corner"
SIZES = [(20, 8), (40, 12), (60, 20), (80, 24), (120, 40)]


def state(**axes: Any) -> TopState:
    made = TopState(status(**axes), now_ns=30 * NS)
    made.rates = dict.fromkeys(axes, (12.0, 3456.0))
    made.plots = [Plot(axis, "position_deg", "deg", 30 * NS, interval_ns=NS // 8) for axis in axes]
    for plot in made.plots:
        plot.add([(at * NS / 8, float(at % 50)) for at in range(240)], 1)
    made.events.extend(
        {"at_ns": at * NS, "of": "m1", "text": "line \x1b[2J" * 9, "number": at} for at in range(9)
    )
    return made


def texts(made: TopState, width: int, height: int) -> list[str]:
    return ["".join(text for text, _ in line) for line in made.frame(width, height)]


def test_a_ramp_rises() -> None:
    lines = drawn([(float(value), float(value)) for value in range(8)], 2, 0.0, 8.0)
    assert lines[0].startswith("\u2800\u2800")
    assert lines[1].endswith("\u2800\u2800")


def test_neighbours_are_joined_and_gaps_are_not() -> None:
    assert drawn([(0.0, 0.0), (7.0, 7.0)], 1, 0.0, 8.0) == ["\u2878"]
    assert drawn([(0.0, 0.0), None, (0.0, 0.0), None], 1, 0.0, 8.0) == ["\u2840\u2840"]


@given(
    st.lists(
        st.one_of(st.none(), st.tuples(*[st.floats(-1e9, 1e9)] * 2).map(sorted).map(tuple)), max_size=60
    ),
    st.integers(1, 9),
)
def test_every_plot_has_its_size(spans: Any, height: int) -> None:
    lines = drawn(spans, height, -10.0, 10.0)
    assert [len(line) for line in lines] == [-(-len(spans) // 2)] * height


@pytest.mark.parametrize(("width", "height"), SIZES)
@pytest.mark.parametrize("count", [1, 3, 40])
def test_a_frame_fits_and_ends_with_the_keys(width: int, height: int, count: int) -> None:
    shown = texts(state(**{f"m{number}": SERVO for number in range(count)}), width, height)
    assert len(shown) == height
    assert max(map(len, shown)) <= width
    assert shown[-1] == KEYS[:width]
    assert "\x1b" not in "".join(shown)


def test_at_sixty_columns_all_is_there() -> None:
    made = state(m1=SERVO, **{NAME: SERVO})
    made.chosen = NAME
    shown = texts(made, 60, 30)
    assert shown[0].startswith("bench b  30.0 s  speed 1  health: ")
    assert sum("in B/s" in line for line in shown) == 1
    assert sum(line.startswith("> spindle") for line in shown) == 1
    assert sum("m1.position_deg" in line for line in shown) == 1
    assert sum("-30 s" in line for line in shown) == 1


def test_the_chosen_axis_of_many_is_shown() -> None:
    made = state(**{f"m{number}": SERVO for number in range(40)})
    for name in ("m0", "m20", "m39"):
        made.chosen = name
        assert any(line.startswith(f"> {name} ") for line in texts(made, 80, 24))
    assert any("more axes" in line for line in texts(made, 80, 24))


def test_before_the_bench_is_there_it_waits() -> None:
    shown = texts(TopState(waiting="waits for lab: nobody listens"), 60, 10)
    assert shown[0] == "waits for lab: nobody listens"
    assert len(shown) == 10


def test_a_plot_keeps_its_window_and_its_extremes() -> None:
    plot = Plot("m1", "e", "deg", 10 * NS, interval_ns=NS)
    plot.add([(at * NS // 2, -1.0 if at % 2 else 5.0) for at in range(100)], 1)
    assert len(plot.spans) == 11
    assert all(each[1:] == (-1.0, 5.0) for each in plot.spans)
    plot.add([(60 * NS, float("nan"))], 1)
    assert len(plot.spans) == 11
