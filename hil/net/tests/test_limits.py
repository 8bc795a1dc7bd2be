from collections.abc import Callable

from hil.net.visitors import AGAIN_S, Limit


class Clock:
    """Stand-in for an event loop's timers: ``run`` lets time pass."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.due: list[tuple[float, Callable[[], None]]] = []

    def call_later(self, delay_s: float, call: Callable[[], None]) -> "Clock":
        self.due.append((self.now_s + delay_s, call))
        return self

    def cancel(self) -> None:
        self.due.clear()

    def run(self, seconds: float) -> None:
        self.now_s += seconds
        due, self.due = self.due, []
        for at_s, call in due:
            if at_s <= self.now_s:
                call()
            else:
                self.due.append((at_s, call))


def test_a_limit_is_said_once_and_then_with_a_count() -> None:
    clock, said = Clock(), list[str]()
    limit = Limit(said.append, clock)
    for _ in range(1000):
        limit.reached("full")
    assert said == ["full"]
    clock.run(AGAIN_S)
    assert said == ["full", "full (999 more in the last 60 s)"]
    for _ in range(5):
        limit.reached("full")
    clock.run(AGAIN_S)
    assert said[2:] == ["full (5 more in the last 60 s)"]
    clock.run(AGAIN_S)
    assert len(said) == 3
    limit.reached("full")  # a new time
    assert said[3:] == ["full"]
    assert limit.count == 1006


def test_a_closed_limit_says_nothing_more() -> None:
    clock, said = Clock(), list[str]()
    limit = Limit(said.append, clock)
    limit.reached("full")
    limit.reached("full")
    limit.close()
    limit.close()
    clock.run(AGAIN_S)
    assert said == ["full"]
