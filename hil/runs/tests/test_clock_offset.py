"""Comparing clocks: the offset lies within what the estimate says, whatever the ways take."""

from hypothesis import given
from hypothesis import strategies as st

from hil.runs import ClockOffset
from hil.runs.clock_offset import WINDOW

WAYS = st.lists(st.tuples(st.integers(0, 10**9), st.integers(0, 10**9)), min_size=1, max_size=3 * WINDOW)


@given(offset_ns=st.integers(-(10**18), 10**18), ways=WAYS)
def test_the_offset_is_within_its_error(offset_ns: int, ways: list[tuple[int, int]]) -> None:
    clock, now_ns = ClockOffset(), 0
    for there_ns, back_ns in ways:
        told_ns = now_ns + there_ns + offset_ns
        clock.add(now_ns, told_ns, now_ns + there_ns + back_ns)
        now_ns += there_ns + back_ns + 1
    assert abs(clock.offset_ns - offset_ns) <= clock.error_ns + 1
    assert clock.error_ns == min(there + back for there, back in ways[-WINDOW:]) // 2


def test_a_clock_that_drifts_is_followed() -> None:
    clock = ClockOffset()
    for n in range(1000):  # ten a second, and one part in ten thousand faster
        asked_ns = n * 100_000_000
        there_ns = asked_ns + 200_000
        clock.add(asked_ns, there_ns + there_ns // 10_000, asked_ns + 400_000)
    assert abs(clock.offset_ns - 100_000_000_000 // 10_000) < 600_000


def test_before_the_first_exchange_nothing_is_known() -> None:
    assert (ClockOffset().offset_ns, ClockOffset().error_ns) == (0, 0)
