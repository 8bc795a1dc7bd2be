"""Ear of a module: requests, each at exactly the time at which its ninth character is complete."""

from bisect import bisect_right
from collections.abc import Callable

from hil.sim.flight import Flight
from hil.vocab.time import FOREVER, Clock, SimTimeNs
from tmcl_bus.frames import BROKEN_OFF_NS, FRAME_BYTES

Ended = Callable[[SimTimeNs, bytes], None]


class ModuleEar:
    """Receiver of frames. ``ended(now_ns, raw)`` is called with the nine bytes of each; a frame that has a
    character with an error, or a silence within it, is dropped.

    A segment announces characters ahead of their times, and takes back what turns out otherwise.
    """

    def __init__(self, clock: Clock, ended: Ended) -> None:
        self._clock, self._ended = clock, ended
        self._times_ns: list[int] = []
        """Times at which characters are complete, ascending."""
        self._data = bytearray()
        self._spoiled: set[int] = set()
        self._due_ns: int = FOREVER

    def hear(self, flight: Flight) -> None:
        """Take characters that are complete from now on."""
        self._times_ns += flight.times_ns
        self._data += flight.data
        self._spoiled |= flight.spoiled
        self._plan()

    def retract(self, after_ns: SimTimeNs) -> None:
        """Take back what would be complete after this time."""
        left = bisect_right(self._times_ns, after_ns)
        del self._times_ns[left:], self._data[left:]
        self._plan()

    def _plan(self) -> None:
        """Be there at the end of the next frame."""
        times_ns = self._times_ns
        broken = [at for at in range(1, min(len(times_ns), FRAME_BYTES)) if self._is_broken_off(at)]
        if broken:
            self._drop(broken[-1])
        is_whole = len(times_ns) >= FRAME_BYTES
        due_ns = times_ns[FRAME_BYTES - 1] if is_whole else FOREVER
        if due_ns != self._due_ns:
            self._due_ns = due_ns
            if is_whole:
                self._clock.at(SimTimeNs(due_ns), self._end)

    def _is_broken_off(self, at: int) -> bool:
        """True if a silence stands before a character."""
        return self._times_ns[at] - self._times_ns[at - 1] > BROKEN_OFF_NS

    def _drop(self, count: int) -> None:
        self._spoiled.difference_update(self._times_ns[:count])
        del self._times_ns[:count], self._data[:count]

    def _end(self, now_ns: SimTimeNs) -> None:
        if now_ns != self._due_ns:
            return  # it was taken back
        raw = bytes(self._data[:FRAME_BYTES])
        is_spoiled = not self._spoiled.isdisjoint(self._times_ns[:FRAME_BYTES])
        self._drop(FRAME_BYTES)
        self._due_ns = FOREVER
        self._plan()
        if not is_spoiled:
            self._ended(now_ns, raw)
