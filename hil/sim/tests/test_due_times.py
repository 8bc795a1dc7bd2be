"""Due times in the order of a plain heap of (time, index), whatever is added while they are taken."""

from collections.abc import Iterator
from heapq import heappop, heappush

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.sim.group import DueTimes
from hil.vocab.time import FOREVER

INDICES = st.integers(0, 5)
TIMES = st.integers(0, 12) | st.just(FOREVER)


class Heap:
    """The same, slow and simple."""

    def __init__(self, due: list[int]) -> None:
        self._due = due
        self._heap: list[tuple[int, int]] = []

    def add(self, due_ns: int, index: int) -> None:
        if due_ns < FOREVER:
            heappush(self._heap, (due_ns, index))

    @property
    def first_ns(self) -> int:
        return min((due_ns for due_ns, index in self._heap if self._due[index] == due_ns), default=FOREVER)

    def take(self, now_ns: int) -> Iterator[int]:
        while self._heap and self._heap[0][0] <= now_ns:
            yield heappop(self._heap)[1]


def run(
    times: DueTimes | Heap, due: list[int], now_ns: int, notes: list[tuple[int, int]], later: list[int]
) -> tuple[list[int], int]:
    """Run what is due; each is due again then, and another may be, earlier than it was."""
    noted, after, order = iter(notes), iter(later), []
    for index, due_ns in enumerate(due):
        times.add(due_ns, index)
    for index in times.take(now_ns):
        if due[index] <= now_ns:
            order.append(index)
            due[index] = next(after, FOREVER)
            other, due_ns = next(noted, (index, FOREVER))
            if due_ns < due[other]:
                due[other] = due_ns
                times.add(due_ns, other)
        times.add(due[index], index)
    return order, times.first_ns


@given(st.lists(TIMES, min_size=6, max_size=6), st.lists(st.tuples(INDICES, TIMES)), st.lists(TIMES), TIMES)
def test_the_order_is_a_heaps(
    first: list[int], notes: list[tuple[int, int]], later: list[int], now_ns: int
) -> None:
    fast, slow = list(first), list(first)
    now_ns = min(now_ns, 10**6)
    assert run(DueTimes(fast.__getitem__), fast, now_ns, notes, later) == run(
        Heap(slow), slow, now_ns, notes, later
    )


def test_who_breaks_off_loses_nothing_that_was_not_taken() -> None:
    times = DueTimes(lambda index: 3)
    for index in range(4):
        times.add(3, index)

    def broken_off() -> None:
        for index in times.take(3):
            if index == 1:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        broken_off()
    assert (times.first_ns, list(times.take(3))) == (3, [2, 3])
