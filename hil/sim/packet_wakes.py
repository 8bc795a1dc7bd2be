"""Wakes of a sketch that reads packets. This optimisation lets 252 boards be on one line.

A sketch that waits for bytes would run for each one that comes. One that has said how its bytes are packets
(``hil.vocab.firmware.Uart.wake_on``) is woken only for characters with which a packet may end: while its main
loop takes bytes as they come, it would only put those before into a memory of its own, which nobody sees.
They still reach its UART at their times, and it reads all of them when it runs, for whatever reason.

Which characters these are the framing says from the character and what stood before it on the line. That is
right as long as the sketch gets what is on the line. Where it may not, every character that could be an end
after anything counts (the framing is asked without what stood before): no packet is seen late, and a wake too
many costs time and changes nothing. That is so

- for what is on the line already when the sketch says so: it may have read the beginning otherwise;
- while the main loop does something else than wait for bytes, until what it has printed is out: meanwhile
  each byte takes room in the UART's buffer, and may find none (``loosen``, ``tighten``);
- after bytes were lost so, forever (``note_gap``);
- after a collision has taken back what was announced: what stands before is not known (``forget``).
"""

from collections.abc import Iterable

from hil.sim._each_packet import Wakes
from hil.vocab.framing import Framing
from hil.vocab.time import FOREVER

Characters = Iterable[tuple[int, int]]
"""Times at which characters are complete, ascending, and the characters."""


class PacketWakes(Wakes):
    """Times at which characters are complete that the sketch is woken for, ``times_ns``.

    ``framing``: of the bytes for the sketch; None: each byte wakes it, and the times here mean nothing.
    ``is_loose``: true if each character counts that ends a packet after some bytes, whatever came before it.
    ``has_gap``: true once characters were lost to an overrun. ``before``: the last bytes on the line, as far
    as they are known. ``add(flight)`` adds characters behind all others, and answers the times among them
    that wake the sketch.
    """

    @property
    def next_ns(self) -> int:
        return self.times_ns[0] if self.times_ns else FOREVER

    def set(self, framing: Framing | None, flying: Characters) -> None:
        """Wake by a framing. ``flying``: what is on the line already."""
        self.framing = framing
        self._renew(flying)

    def loosen(self, flying: Characters) -> None:
        self.is_loose = True
        self._renew(flying)

    def tighten(self) -> None:
        """Go by what stands before again; what is on the line already counts as it did."""
        self.is_loose = False

    def note_gap(self, flying: Characters) -> None:
        """Note that characters were lost to an overrun."""
        self.has_gap = True
        self._renew(flying)

    def forget(self, flying: Characters) -> None:
        """Forget what stood before: ``flying`` is left of what was announced."""
        self.before = b""
        self._renew(flying)

    def drop_until(self, now_ns: int) -> None:
        """Drop the times up to now."""
        while self.times_ns and self.times_ns[0] <= now_ns:
            self.times_ns.popleft()

    def _renew(self, flying: Characters) -> None:
        pairs = list(flying) if self.framing is not None else []
        self.times_ns.clear()
        if self.framing is not None and pairs:
            data = bytes(byte for _, byte in pairs)
            self.times_ns.extend(pairs[place][0] for place in self.framing.ends(data, None))
