"""The order of items: exact where they can be had twice, within a window where they come."""

from collections.abc import Iterable, Iterator
from itertools import islice

import pytest

from hil.cli.captures.time_order import ReorderWindow, in_order, in_window
from hil.compose.decoded_item import DecodedItem, DecodedKind
from hil.wire.pcapng import CaptureError


def item(at_ns: int, name: str = "") -> DecodedItem:
    return DecodedItem(at_ns, name, DecodedKind.BYTES, str)


def times(items: Iterable[DecodedItem]) -> list[int]:
    return [each.at_ns for each in items]


@pytest.mark.parametrize("given", [[], [1], [3, 1, 2], [9, 8, 7, 1], [1, 5, 2, 2, 9, 0], list(range(50))])
def test_what_can_be_had_twice_is_sorted(given: list[int]) -> None:
    assert times(in_order(lambda: map(item, given))) == sorted(given)


def test_times_that_cannot_be_end_no_reading() -> None:
    given = [5, -(10**21), 10**27, 7]
    assert [each.at_ns for each in in_order(lambda: map(item, given))] == sorted(given)


def test_equal_times_stay_as_they_come() -> None:
    given = [item(5, "a"), item(3, "b"), item(5, "c"), item(3, "d")]
    assert [each.source for each in in_order(lambda: given)] == ["b", "d", "a", "c"]
    assert [each.source for each in in_window(given)] == ["b", "d", "a", "c"]


def test_only_what_is_out_of_order_is_held() -> None:
    """The first ones are given before the last ones are read a second time."""
    readings = []

    def again() -> Iterator[DecodedItem]:
        for at in range(1000):
            readings.append(at)
            yield item(at ^ 1)

    assert times(islice(in_order(again), 4)) == [0, 1, 2, 3]
    assert len(readings) == 1000 + 4


@pytest.mark.parametrize("order", [lambda again: in_order(again), lambda again: in_window(again())])
def test_what_is_whole_comes_before_the_error(order: object) -> None:
    def again() -> Iterator[DecodedItem]:
        yield from map(item, [2, 1])
        raise CaptureError("cut off")

    assert callable(order)
    items = order(again)
    assert times(islice(items, 2)) == [1, 2]
    with pytest.raises(CaptureError, match="cut off"):
        next(items)


def test_a_window_holds_until_it_is_later_or_silent() -> None:
    window = ReorderWindow(10)
    assert times(window.put(map(item, [5, 3, 12]))) == []
    assert times(window.put([item(14)])) == [3]
    assert times(window.put([item(24)])) == [5, 12, 14]
    assert times(window.put([item(1)])) == [1]  # too late for its place
    assert times(window.rest()) == [24]
    assert times(in_window([item(2), item(1), None, item(0)])) == [1, 2, 0]
