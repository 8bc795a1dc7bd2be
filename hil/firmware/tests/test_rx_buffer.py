from hypothesis import given
from hypothesis import strategies as st

from hil.firmware.runtime import RxBuffer

STEPS = st.lists(st.binary(max_size=6) | st.sampled_from(["read", "peek"]), max_size=60)


@given(st.integers(1, 8), STEPS)
def test_a_buffer_is_a_list_with_one_byte_held_beside_it(capacity: int, steps: list[bytes | str]) -> None:
    rx = RxBuffer(capacity)
    held: list[int] = []
    unread: list[int] = []
    for step in steps:
        if isinstance(step, bytes):
            taken = min(len(step), capacity - len(unread))
            assert rx.feed(step) == taken
            unread += step[:taken]
        else:
            if not held and unread:
                held = [unread.pop(0)]
            expected = held[0] if held else -1
            assert (rx.read() if step == "read" else rx.peek()) == expected
            if step == "read":
                held = []
        assert rx.available() == len(unread)
        assert rx.room() == capacity - len(unread)


def test_a_peeked_byte_is_not_counted_and_takes_no_room() -> None:
    rx = RxBuffer(2)
    assert rx.feed(b"abc") == 2
    assert rx.peek() == ord("a")
    assert (rx.available(), rx.room()) == (1, 1)
    assert rx.feed(b"c") == 1
    assert [rx.read() for _ in range(4)] == [*b"abc", -1]
