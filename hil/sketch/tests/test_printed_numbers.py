"""Numbers that a sketch prints, as a plotter reads them."""

import json
import math
from pathlib import Path

import pytest

from hil.sketch.printed_numbers import MOST_LINE_BYTES, MOST_NAMES, PrintedNumbers, numbers_in

LINES = Path(__file__).with_name("printed_lines.json")
"""Lines that the terminal of the page reads in the same way: web/tests/printed_numbers.test.ts."""


@pytest.mark.parametrize(("line", "numbers"), json.loads(LINES.read_text("utf-8")))
def test_lines_of_numbers_and_others(line: str, numbers: dict[str, float]) -> None:
    assert numbers_in(line) == numbers


def test_a_series_begins_with_the_first_whole_line() -> None:
    printed = PrintedNumbers()
    for at_ns, data in enumerate((b"7\n1", b"0\nready\n20", b"\r\n\n")):
        printed.add(at_ns, data)
    assert printed.rows == [(0, 10), (1, 20)]
    assert printed.others == 1


def test_a_name_that_comes_later_has_no_number_before() -> None:
    printed = PrintedNumbers()
    printed.add(5, b"\na:1\nb:2\na:3\n")
    assert printed.names == ["a", "b"]
    first, *rest = printed.table()
    assert first[:2] == (0, 1)
    assert math.isnan(first[2])
    assert rest == [(0, 1, 2), (0, 3, 2)]


def test_a_line_of_which_something_is_missing_is_none() -> None:
    printed = PrintedNumbers()
    printed.add(0, b"\n1")
    printed.break_off()
    printed.add(1, b"5\n6\n")
    printed.add(2, b"1" * (MOST_LINE_BYTES + 1))
    printed.add(3, b"2\n7\n")
    assert printed.rows == [(0, 6), (2, 7)]


def test_names_without_end_are_other_text() -> None:
    printed = PrintedNumbers()
    printed.add(0, b"\n" + b"".join(b"n%d:1\n" % n for n in range(MOST_NAMES + 5)))
    assert len(printed.names) == len(printed.rows) == MOST_NAMES
    assert printed.others == 5
