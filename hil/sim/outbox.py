"""What a device's firmware writes, on its way to those who listen at its UARTs."""

from itertools import groupby
from operator import itemgetter

from hil.sim.stops import Guard
from hil.sim.uart import DeviceUart, Written
from hil.vocab.time import SimTimeNs

LAST_WORDS_BYTES = 128 * 1024
"""More than the longest answer, a look-up table."""


class Outbox:
    """Of one device, for all its UARTs. A firmware's turn only notes what it writes; faults and the line's
    times are reckoned outside of it, where the guard cannot strike."""

    def __init__(self, guard: Guard) -> None:
        self._guard = guard
        self.written: list[Written] = []
        """What the firmware has written in this turn."""
        self._put = 0
        """How many of these are on the line."""
        self._sent: list[tuple[DeviceUart, SimTimeNs, bytes]] = []

    def sent(self, uart: DeviceUart, at_ns: SimTimeNs, data: bytes) -> None:
        """Bytes are on the line of a UART."""
        self._sent.append((uart, at_ns, data))

    def put(self) -> None:
        """Put on the line what was written so far in this turn, for its times to be known."""
        if self._put < len(self.written):
            with self._guard.aside():
                self._put_written()

    def hand_on(self) -> None:
        """After a turn: all that was written goes to who listens."""
        if self.written or self._sent:
            with self._guard.aside():
                self._put_written()
                self.written.clear()
                self._put = 0
                self._empty()

    def last_words(self) -> list[Written]:
        """Of a firmware that printed for ever in one turn, what a client may still want to see."""
        left, words = LAST_WORDS_BYTES, self.written[: self._put]
        for uart, baud, data in self.written[self._put :]:
            words.append((uart, baud, data[:left]))
            left -= len(data)
            if left <= 0:
                break
        return words

    def _put_written(self) -> None:
        for uart, baud, data in self.written[self._put :]:
            uart.put(data, baud)
        self._put = len(self.written)

    def _empty(self) -> None:
        """What went on the line at one time is one piece."""
        sent, self._sent = self._sent, []
        if len(sent) == 1:
            uart, at_ns, data = sent[0]
            for listener in uart.listeners:
                listener(at_ns, data)
            return
        for (uart, at_ns), pieces in groupby(sent, key=itemgetter(0, 1)):
            whole = b"".join(data for _, _, data in pieces)
            for listener in uart.listeners:
                listener(at_ns, whole)
