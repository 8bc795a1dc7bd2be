"""Transmit side of a UART: from what the sketch has written to the line, through faults and at its times."""

from collections.abc import Callable

from hil.vocab.time import SimTimeNs
from hil.wire.byte_faults import ByteFaults, apply_all
from hil.wire.serial_line import character_ns

Sent = Callable[[SimTimeNs, bytes], None]
"""Called with what is sent: the time of its first bit on the line, and the bytes."""


class Transmitter:
    """Transmit side of a UART. ``sent(start_ns, data)`` is called for all that leaves: without a baud all of
    it is on the line at ``start_ns``, else byte i has been sent at ``start_ns + character_ns(i + 1, baud)``.
    ``buffer_bytes``: 0 for a UART made in software, whose print waits for the last bit."""

    def __init__(self, sent: Sent, buffer_bytes: int) -> None:
        self.faults: dict[int, ByteFaults] = {}
        """Faults of what is sent, by their numbers."""
        self.free_ns = 0
        """Time at which the last byte written so far has gone out; without a baud 0."""
        self._sent = sent
        self._buffer_bytes = buffer_bytes

    def put(self, now_ns: SimTimeNs, baud: int | None, data: bytes) -> None:
        """Send what was written, through the faults."""
        for delay_ns, piece in apply_all(self.faults.values(), data) if self.faults else ((0, data),):
            self._send(now_ns, baud, piece, delay_ns)

    def _send(self, now_ns: SimTimeNs, baud: int | None, data: bytes, delay_ns: int) -> None:
        if baud is None:
            self._sent(now_ns, data)
            return
        start_ns = max(now_ns + delay_ns, self.free_ns)
        self.free_ns = start_ns + character_ns(len(data), baud)
        self._sent(SimTimeNs(start_ns), data)

    def print_returns(self, now_ns: SimTimeNs, baud: int | None) -> SimTimeNs:
        """Time at which all but a transmit buffer of what was written has gone out."""
        if baud is None or self.free_ns <= now_ns:
            return now_ns
        return SimTimeNs(max(now_ns, self.free_ns - character_ns(self._buffer_bytes, baud)))
