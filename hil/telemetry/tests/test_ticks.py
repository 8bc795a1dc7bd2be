"""Ticks of drawings are round numbers, and a signal that stands still has some, too."""

import math
from fractions import Fraction
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.telemetry.recording import Recording
from hil.telemetry.text_plot import draw, round_ticks, shown_range

NUMBERS = st.floats(-1e6, 1e6)


@given(NUMBERS, st.floats(1e-2, 1e6), st.integers(2, 12))
def test_ticks_are_round_and_what_they_say(low: float, width: float, most: int) -> None:
    ticks, texts = round_ticks(low, low + width, most)
    assert len(ticks) == len(texts) <= most
    assert all(low - 1e-9 * width - 1e-9 <= tick <= low + width * (1 + 1e-9) + 1e-9 for tick in ticks)
    assert len(set(texts)) == len(texts)
    steps = {Fraction(later) - Fraction(tick) for tick, later in pairwise(texts)}
    assert len(steps) <= 1
    for step in steps:
        assert float(step) / 10 ** math.floor(math.log10(step) + 1e-9) in (1, 2, 2.5, 5)


@pytest.mark.parametrize(
    ("low", "high", "most", "texts"),
    [
        (0, 2, 5, ["0.0", "0.5", "1.0", "1.5", "2.0"]),
        (6.29, 367.15, 6, ["100", "200", "300"]),
        (-0.00013, 0.0007, 5, ["0.0000", "0.0002", "0.0004", "0.0006"]),
        (0, 2.49, 10, ["0.00", "0.25", "0.50", "0.75", "1.00", "1.25", "1.50", "1.75", "2.00", "2.25"]),
        (-3, 8, 6, ["-2", "0", "2", "4", "6", "8"]),
    ],
)
def test_texts_of_ticks(low: float, high: float, most: int, texts: list[str]) -> None:
    assert round_ticks(low, high, most)[1] == texts


def test_a_signal_that_stands_still_has_a_range() -> None:
    assert shown_range([0.0, 4.08e-103, -3e-17]) == (-1.0 + -3e-17, 1.0 + 4.08e-103)
    assert shown_range([6.3] * 3) == pytest.approx((5.3, 7.3))
    assert shown_range([math.nan, math.inf]) == (-1.0, 1.0)
    assert shown_range([2.0, 5.0]) == (2.0, 5.0)


def test_a_drawing_has_round_ticks_alone() -> None:
    rows = [(at_ms * 1_000_000, 6.3 + at_ms * 0.317, 4.08e-103) for at_ms in range(500)]
    drawn = draw({"": Recording(("yw", "velocity_rpm"), rows)}, 80, colour=False)
    labels = [line.split("┤")[0].strip() for line in drawn.splitlines() if "┤" in line]
    assert [label for label in labels if label] == [
        "150",
        "125",
        "100",
        "75",
        "50",
        "25",
        "1.0",
        "0.5",
        "0.0",
        "-0.5",
        "-1.0",
    ]
    assert drawn.splitlines()[-2].split() == ["0.0", "0.1", "0.2", "0.3", "0.4"]
