"""Times at which a node has to do something of its own accord, in one heap."""

from collections.abc import Callable
from heapq import heappop, heappush, heapreplace

from hil.vocab.time import FOREVER


class Timer:
    """A call at a time, once. It is made by ``Timers.make``."""

    __slots__ = ("_timers", "at_ns", "call", "number", "queued_ns")

    def __init__(self, timers: "Timers", number: int, call: Callable[[int], None]) -> None:
        self._timers, self.number, self.call = timers, number, call
        self.at_ns: int = FOREVER
        self.queued_ns: int = FOREVER
        """Time of its entry in the heap, which is never later than its own."""

    @property
    def is_running(self) -> bool:
        return self.at_ns != FOREVER

    def start(self, at_ns: int) -> None:
        """Make the call at a time, and not at the one that was set before; at FOREVER not at all."""
        self.at_ns = at_ns
        timers = self._timers
        if at_ns < self.queued_ns:
            self.queued_ns = at_ns
            heappush(timers.heap, (at_ns, self.number, self))
            if at_ns < timers.due_ns:
                timers.due_ns = at_ns
        elif self.queued_ns == timers.due_ns:
            timers.settle()

    def stop(self) -> None:
        if self.at_ns != FOREVER:
            self.start(FOREVER)


class Timers:
    """All timers of a node. Of one time the one that was made first is called first.

    An entry of the heap is outdated if its time is another than its timer's: it is put right when it comes to
    the top, so that a time-out that begins again and again costs nothing.
    """

    def __init__(self) -> None:
        self.heap: list[tuple[int, int, Timer]] = []
        self.due_ns: int = FOREVER
        """Time of the next call; FOREVER if there is none."""
        self._all: list[Timer] = []

    def make(self, call: Callable[[int], None]) -> Timer:
        """Make a timer, which does not run yet."""
        self._all.append(Timer(self, len(self._all), call))
        return self._all[-1]

    def settle(self) -> None:
        """Put entries at the top right that are outdated."""
        heap = self.heap
        while heap and heap[0][0] != heap[0][2].at_ns:
            queued_ns, number, timer = heap[0]
            if queued_ns != timer.queued_ns:
                heappop(heap)
                continue
            timer.queued_ns = timer.at_ns
            if timer.at_ns != FOREVER:
                heapreplace(heap, (timer.at_ns, number, timer))
            else:
                heappop(heap)
        self.due_ns = heap[0][0] if heap else FOREVER

    def run(self, now_ns: int) -> None:
        """Make all calls that are due. A call may start timers, its own too, for later."""
        heap = self.heap
        while self.due_ns <= now_ns:
            timer = heappop(heap)[2]
            timer.at_ns = timer.queued_ns = FOREVER
            if heap and heap[0][0] != heap[0][2].at_ns:
                self.settle()
            else:
                self.due_ns = heap[0][0] if heap else FOREVER
            timer.call(now_ns)

    def stop(self) -> None:
        for timer in self._all:
            timer.stop()
