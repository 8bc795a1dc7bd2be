"""Times at which a node has to do something of its own accord."""

from collections.abc import Callable

from hil.vocab.time import FOREVER


class Timer:
    """A call at a time, once. It is made by ``Timers.make``."""

    __slots__ = ("_timers", "at_ns", "call")

    def __init__(self, timers: "Timers", call: Callable[[int], None]) -> None:
        self._timers = timers
        self.call = call
        self.at_ns: int = FOREVER

    @property
    def is_running(self) -> bool:
        return self.at_ns != FOREVER

    def start(self, at_ns: int) -> None:
        """Make the call at a time, and not at the one that was set before."""
        self.at_ns = at_ns
        self._timers.due_known = False

    def stop(self) -> None:
        if self.at_ns != FOREVER:
            self.at_ns = FOREVER
            self._timers.due_known = False


class Timers:
    """All timers of a node. Of one time the one that was made first is called first."""

    def __init__(self) -> None:
        self._all: list[Timer] = []
        self._due_ns: int = FOREVER
        self.due_known = True

    def make(self, call: Callable[[int], None]) -> Timer:
        """Make a timer, which does not run yet."""
        self._all.append(Timer(self, call))
        return self._all[-1]

    @property
    def due_ns(self) -> int:
        """Time of the next call; FOREVER if there is none."""
        if not self.due_known:
            self._due_ns = min([each.at_ns for each in self._all])
            self.due_known = True
        return self._due_ns

    def run(self, now_ns: int) -> None:
        """Make all calls that are due. A call may start timers, its own too, for later."""
        while self.due_ns <= now_ns:
            timer = min(self._all, key=lambda each: each.at_ns)
            timer.stop()
            timer.call(now_ns)

    def stop(self) -> None:
        for timer in self._all:
            timer.stop()
