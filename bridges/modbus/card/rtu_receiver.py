"""A station's ear for Modbus RTU: frames, at exactly the time at which the silence behind each is over."""

from bisect import bisect_right
from collections.abc import Callable
from itertools import pairwise

from bridges.modbus.protocol.frame import FRAME_BYTES_MAX, FRAME_BYTES_MIN, Frame
from hil.sim.flight import Flight
from hil.vocab.line_format import LineFormat
from hil.vocab.time import FOREVER, Clock, SimTimeNs
from hil.wire.serial_line import character_ns, gap_ns, silence_ns

Ended = Callable[[SimTimeNs, SimTimeNs, bytes], None]
_KEPT_BYTES = 4 * FRAME_BYTES_MAX


class RtuReceiver:
    """Receiver of one speed and format. ``ended(now_ns, start_ns, raw)`` is called when a frame has ended
    that began at ``start_ns`` and is one: no silence of more than 1.5 characters within it, no character with
    an error, its CRC right. What is none is dropped.

    A segment announces characters ahead of their times, and takes back what turns out otherwise.
    """

    def __init__(self, clock: Clock, baud: int, line_format: LineFormat, ended: Ended) -> None:
        self._clock, self._ended = clock, ended
        self._one_ns = character_ns(1, baud, line_format.bits)
        self._gap_ns = gap_ns(baud, line_format.bits)
        self._silence_ns = silence_ns(baud, line_format.bits)
        self._times_ns: list[int] = []
        """Times at which characters are complete, ascending: those of the frame that has not ended, and what
        was announced behind it."""
        self._data = bytearray()
        self._spoiled: set[int] = set()
        """Times of characters with errors."""
        self._size = 0
        """Number of characters of the frame that ends next."""
        self._over_ns: int = FOREVER
        """Time at which it ends."""
        self._is_long = False
        """True if characters of the frame that ends next were dropped, because it has too many."""

    def feed(self, flight: Flight) -> None:
        """Take characters that are complete from now on."""
        self._times_ns += flight.times_ns
        self._data += flight.data
        if flight.spoiled:
            self._spoiled |= flight.spoiled
        if self._size > _KEPT_BYTES:
            self._drop()
        self._find_end(max(self._size - 1, 0), 0)

    def _drop(self) -> None:
        """Drop characters that are complete, of a frame that has too many: a babbling line never ends one."""
        count = min(bisect_right(self._times_ns, self._clock.now_ns), self._size) - 1
        if count > FRAME_BYTES_MAX:
            del self._times_ns[:count], self._data[:count]
            self._size -= count
            self._is_long = True
            self._spoiled = {at_ns for at_ns in self._spoiled if at_ns >= self._times_ns[0]}

    def retract(self, after_ns: SimTimeNs) -> None:
        """Take back what would be complete after this time. The line goes on: the frame does not end before
        it could be silent again."""
        if not self._times_ns or self._times_ns[-1] <= after_ns:
            return
        left = bisect_right(self._times_ns, after_ns)
        del self._times_ns[left:], self._data[left:]
        self._spoiled = {at_ns for at_ns in self._spoiled if at_ns <= after_ns}
        self._size = min(self._size, left)
        self._find_end(max(self._size - 1, 0), after_ns + self._silence_ns)

    def _find_end(self, first: int, not_before_ns: int) -> None:
        """Find the end of the frame that ends next, and be there. ``first``: before this character it does
        not end."""
        times_ns, longest_ns = self._times_ns, self._one_ns + self._silence_ns
        if not times_ns:
            self._size, self._over_ns = 0, FOREVER
            return
        last = len(times_ns) - 1
        end = next((at for at in range(first, last) if times_ns[at + 1] - times_ns[at] >= longest_ns), last)
        self._size = end + 1
        over_ns = times_ns[end] + self._silence_ns
        if end == last:
            over_ns = max(over_ns, not_before_ns)
        if over_ns != self._over_ns:
            self._over_ns = over_ns
            self._clock.at(over_ns, self._end)

    def _end(self, now_ns: SimTimeNs) -> None:
        if now_ns != self._over_ns:
            return  # more has come since
        size, self._over_ns = self._size, FOREVER
        times_ns, raw = self._times_ns[:size], bytes(self._data[:size])
        del self._times_ns[:size], self._data[:size]
        is_frame = not self._is_long and self._is_frame(times_ns, raw)
        self._spoiled.difference_update(times_ns)
        self._size, self._is_long = 0, False
        self._find_end(0, 0)
        if is_frame:
            self._ended(now_ns, SimTimeNs(times_ns[0] - self._one_ns), raw)

    def _is_frame(self, times_ns: list[int], raw: bytes) -> bool:
        if not FRAME_BYTES_MIN <= len(raw) <= FRAME_BYTES_MAX or Frame(0, raw).fault:
            return False
        if self._spoiled and not self._spoiled.isdisjoint(times_ns):
            return False
        longest_ns = self._one_ns + self._gap_ns
        return all(later - at <= longest_ns for at, later in pairwise(times_ns))
