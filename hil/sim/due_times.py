"""Times at which the devices of a group have to run, a heap entry for each time and not for each device.

A packet to everybody makes all devices of a line due at one time: they wait under it in one list.
"""

from collections.abc import Callable, Iterator
from heapq import heappop, heappush

from hil.vocab.time import FOREVER, SimTimeNs


class DueTimes:
    """Due times by the devices' indices, which decide between devices of one time. ``due_of(index)`` is the
    truth: an entry with another time is outdated and means nothing."""

    def __init__(self, due_of: Callable[[int], int]) -> None:
        self._due_of = due_of
        self._times_ns: list[int] = []
        """Heap of all times in ``_waiting``."""
        self._waiting: dict[int, list[int]] = {}
        """Indices by their times; one may stand there twice."""

    def add(self, due_ns: int, index: int) -> None:
        if due_ns == FOREVER:
            return
        if waiting := self._waiting.get(due_ns):
            waiting.append(index)
        else:
            self._waiting[due_ns] = [index]
            heappush(self._times_ns, due_ns)

    @property
    def first_ns(self) -> SimTimeNs:
        """Earliest time that is not outdated; drops those that are."""
        while self._times_ns:
            due_ns = self._times_ns[0]
            waiting = self._waiting[due_ns]
            while waiting and self._due_of(waiting[-1]) != due_ns:
                waiting.pop()
            if waiting:
                return SimTimeNs(due_ns)
            del self._waiting[heappop(self._times_ns)]
        return FOREVER

    def take(self, now_ns: int) -> Iterator[int]:
        """Take the entries up to now, in the order of times and indices, also those that are added meanwhile;
        some are outdated."""
        times_ns = self._times_ns
        while times_ns and times_ns[0] <= now_ns:
            due_ns = heappop(times_ns)
            left = sorted(self._waiting.pop(due_ns), reverse=True)
            try:
                while left:
                    yield left.pop()
                    if times_ns and times_ns[0] <= due_ns:
                        break
            finally:  # entries were added before these, or the taker was broken off
                for index in left:
                    self.add(due_ns, index)
