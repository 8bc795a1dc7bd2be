"""Characters on the line towards a UART, and those that the sketch is woken for."""

from bisect import bisect_right
from collections import deque
from collections.abc import Callable

from hil.sim.flight import Flight
from hil.sim.packet_wakes import PacketWakes
from hil.vocab.framing import Framing
from hil.vocab.time import FOREVER, SimTimeNs

DueChanged = Callable[[SimTimeNs | None], None]
"""Called when characters wake a sketch at another time than was known: this one too, or (None) others."""


class Incoming:
    """Characters that are not in the UART's buffer yet."""

    def __init__(self, due_changed: DueChanged) -> None:
        self.flights: deque[Flight] = deque()
        self.next_ns = FOREVER
        """Time at which the next character is complete, of those that the sketch is woken for."""
        self.wakes = PacketWakes()
        self._due_changed = due_changed
        self._taken = 0
        """Number of characters of the first flight that have come."""

    @property
    def waiting(self) -> int:
        """Number of characters that wait."""
        return sum(len(flight.data) for flight in self.flights) - self._taken

    def characters(self) -> list[tuple[int, int]]:
        """Time at which each is complete, and the character."""
        return [each for flight in self.flights for each in flight.characters()][self._taken :]

    def under_way(self, now_ns: int) -> list[int]:
        """Times at which characters are complete that are not yet, ascending."""
        return [at_ns for at_ns, _ in self.characters() if at_ns > now_ns] if self.flights else []

    def wake_on(self, framing: Framing | None) -> None:
        """Wake as ``hil.vocab.firmware.Uart.wake_on``."""
        self.wakes.set(framing, self.characters())
        self._find_next()

    def loosen(self) -> None:
        """Note that the sketch does not take bytes as they come, until ``wakes.tighten``."""
        self.wakes.loosen(self.characters())
        self._find_next()

    def note_gap(self) -> None:
        """Note that characters were lost to an overrun."""
        self.wakes.note_gap(self.characters())
        self._find_next()

    def add(self, flight: Flight) -> None:
        """Add a flight that is on the line."""
        self.flights.append(flight)
        first_ns = self.wakes.add(flight)
        # It comes behind all others: where a time is known already, that one is earlier.
        if self.next_ns == FOREVER:
            if self.wakes.framing is None:
                first_ns = flight.times_ns[0]
            self.next_ns = SimTimeNs(first_ns)
            self._due_changed(self.next_ns)

    def retract(self, after_ns: int) -> None:
        """Take back what would be complete after this time."""
        if not self.flights:
            self.wakes.forget(())
            return
        left = [each for each in self.characters() if each[0] <= after_ns]
        self.flights.clear()
        self._taken = 0
        if left:
            self.flights.append(Flight(tuple(at_ns for at_ns, _ in left), bytes(byte for _, byte in left)))
        self.wakes.forget(left)
        self._find_next()
        self._due_changed(None)

    def whole(self, now_ns: int, from_ns: int) -> Flight | None:
        """Take off the line what waits, if it is whole packets for everybody, of the framing that the sketch
        reads, that came from ``from_ns`` to now."""
        flights = self.flights
        if len(flights) != 1 or self._taken:
            return None
        flight = flights[0]
        times_ns = flight.times_ns
        if flight.packets is None or flight.framing is not self.wakes.framing:
            return None
        if times_ns[-1] > now_ns or times_ns[0] < from_ns:
            return None
        flights.clear()
        self.wakes.clear()
        self.next_ns = FOREVER
        return flight

    def drain(self, now_ns: int) -> list[Flight]:
        """Take everything that is complete by now off the line."""
        come: list[Flight] = []
        while self.flights:
            flight, first = self.flights[0], self._taken
            if flight.times_ns[-1] <= now_ns:
                self.flights.popleft()
                self._taken = 0
                come.append(flight if first == 0 else flight.part(first, len(flight.data)))
                continue
            end = bisect_right(flight.times_ns, now_ns, first)
            if end > first:
                self._taken = end
                come.append(flight.part(first, end))
            break
        self.wakes.drop_until(now_ns)
        self._find_next()
        return come

    def _find_next(self) -> None:
        if self.wakes.framing is not None:
            self.next_ns = SimTimeNs(self.wakes.next_ns)
        elif self.flights:
            self.next_ns = SimTimeNs(self.flights[0].times_ns[self._taken])
        else:
            self.next_ns = FOREVER
