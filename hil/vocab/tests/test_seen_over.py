"""Figures beside limits that they exceed."""

import pytest

from hil.vocab.seen_over import seen_over


@pytest.mark.parametrize(
    ("value", "limit", "shown"),
    [
        (20.4, 20.0, "20.4"),
        (20.00004, 20.0, "20.00004"),
        (1_000_000.4, 1e6, "1000000.4"),
        (-1_000_000.4, -1e6, "-1000000.4"),
        (90.0, 50.0, "90"),
        (0.29999999, 0.3, "0.29999999"),
        (123_456.0, 5.0, "123456"),
        (0.25, 0.0, "0.25"),
    ],
)
def test_a_figure_is_seen_to_be_over(value: float, limit: float, shown: str) -> None:
    assert seen_over(value, limit) == shown
