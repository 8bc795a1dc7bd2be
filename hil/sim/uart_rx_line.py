"""Characters on the line towards a UART, and those that the sketch is woken for."""

from bisect import bisect_right
from collections.abc import Callable

from hil.sim._each_packet import RxLine, offered
from hil.sim.flight import Flight
from hil.sim.packet_wakes import PacketWakes
from hil.vocab.framing import Framing
from hil.vocab.time import FOREVER, SimTimeNs

DueChanged = Callable[[SimTimeNs | None], None]
"""Called when characters wake a sketch at another time than was known: this one too, or (None) others."""


__all__ = ["DueChanged", "Incoming", "offered"]


class Incoming(RxLine[PacketWakes]):
    """Characters that are not in the UART's buffer yet.

    ``flights``: on the line, in their order; ``taken``: characters of the first that have come. ``next_ns``:
    the time at which the next character is complete, of those that the sketch is woken for. ``unread``: bytes
    in the buffer; ``is_woken``: true if one for which the framing wakes the sketch is among them.
    ``add(flight)`` adds a flight that is on the line.
    """

    def __init__(self, due_changed: DueChanged) -> None:
        super().__init__(PacketWakes(), due_changed)
        self._due_changed = due_changed

    @property
    def waiting(self) -> int:
        """Number of characters that wait."""
        return sum(len(flight.data) for flight in self.flights) - self.taken

    def characters(self) -> list[tuple[int, int]]:
        """Time at which each is complete, and the character."""
        return [each for flight in self.flights for each in flight.characters()][self.taken :]

    def under_way(self, now_ns: int) -> list[int]:
        """Times at which characters are complete that are not yet, ascending."""
        return [at_ns for at_ns, _ in self.characters() if at_ns > now_ns] if self.flights else []

    def wake_on(self, framing: Framing | None) -> None:
        """Wake as ``hil.vocab.firmware.Uart.wake_on``."""
        self.wakes.set(framing, self.characters())
        self._find_next()

    def loosen(self) -> None:
        """Note that the sketch does not take bytes as they come, until ``wakes.tighten``."""
        if not self.flights:  # asked here: nothing is on the line, as mostly when a packet was taken
            self.wakes.is_loose = True
            return
        self.wakes.loosen(self.characters())
        self._find_next()

    def note_gap(self) -> None:
        """Note that characters were lost to an overrun."""
        self.wakes.note_gap(self.characters())
        self._find_next()

    def retract(self, after_ns: int) -> None:
        """Take back what would be complete after this time."""
        if not self.flights:
            self.wakes.forget(())
            return
        left = [each for each in self.characters() if each[0] <= after_ns]
        self.flights.clear()
        self.taken = 0
        if left:
            self.flights.append(Flight(tuple(at_ns for at_ns, _ in left), bytes(byte for _, byte in left)))
        self.wakes.forget(left)
        self._find_next()
        self._due_changed(None)

    def drain(self, now_ns: int) -> list[Flight]:
        """Take everything that is complete by now off the line."""
        come: list[Flight] = []
        done = 0
        for flight in self.flights:
            first = self.taken
            if flight.times_ns[-1] > now_ns:
                end = bisect_right(flight.times_ns, now_ns, first)
                if end > first:
                    self.taken = end
                    come.append(flight.part(first, end))
                break
            done += 1
            self.taken = 0
            come.append(flight if first == 0 else flight.part(first, len(flight.data)))
        del self.flights[:done]
        self.wakes.drop_until(now_ns)
        self._find_next()
        return come

    def _find_next(self) -> None:
        if self.wakes.framing is not None:
            self.next_ns = SimTimeNs(self.wakes.next_ns)
        elif self.flights:
            self.next_ns = SimTimeNs(self.flights[0].times_ns[self.taken])
        else:
            self.next_ns = FOREVER
