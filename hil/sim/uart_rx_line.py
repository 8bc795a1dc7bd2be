"""Characters on the line towards a UART, with their times, and those that the sketch is woken for."""

from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache

from hil.vocab.segment import HeardCharacter
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.serial_line import character_ns, resample


@dataclass(frozen=True, eq=False)
class Flight:
    """Characters on the line, at least one. Equal only to itself, so that it is found quickly."""

    times_ns: tuple[int, ...]
    """Times at which each is complete, ascending."""
    data: bytes

    def part(self, first: int, end: int) -> "Flight":
        return Flight(self.times_ns[first:end], self.data[first:end])

    def characters(self) -> Iterator[tuple[int, int]]:
        return zip(self.times_ns, self.data, strict=True)


class Incoming:
    """Characters that are not in the UART's buffer yet. ``due_changed``: ``next_ns`` may be earlier."""

    def __init__(self, due_changed: Callable[[], None]) -> None:
        self.flights: deque[Flight] = deque()
        self.next_ns = FOREVER
        """Time at which the next character is complete, of those that the sketch is woken for."""
        self.wake_byte: int | None = None
        """Only byte that the sketch is woken for; None: every one."""
        self.ignores_mark = False
        """Whether every wake byte counts, whatever its mark."""
        self._mark: int | None = None
        self._due_changed = due_changed
        self._taken = 0
        """Number of characters of the first flight that have come."""
        self._before = b""
        """Last two bytes on the line, if they are known."""
        self._is_gapless = True
        """Whether what the sketch gets stood on the line just so, with no byte lost in between."""
        self._wakes: deque[int] = deque()

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

    def wake_on(self, byte: int | None, mark: int | None) -> None:
        """Wake as ``hil.vocab.firmware.Uart.wake_on``; what is on the line already needs no mark."""
        self.wake_byte, self._mark = byte, mark
        self._wakes = deque(at_ns for at_ns, flying in self.characters() if flying == byte)
        self._find_next()

    def ignore_mark(self) -> None:
        """Let every wake byte count until ``ignores_mark`` is false again."""
        self.ignores_mark = True
        self.wake_on(self.wake_byte, self._mark)

    def note_gap(self) -> None:
        """Note that characters were lost to an overrun: the bytes before the next one are no longer known."""
        self._is_gapless = False
        self.wake_on(self.wake_byte, self._mark)

    def add(self, flight: Flight) -> None:
        """Add a flight that is on the line."""
        self.flights.append(flight)
        if self.wake_byte is not None:
            mark = self._mark if self._is_gapless and not self.ignores_mark else None
            self._wakes.extend(_wakes(flight, self.wake_byte, mark, self._before))
        self._before = flight.data[-2:]
        if self.next_ns == FOREVER:
            self._find_next()
            self._due_changed()

    def retract(self, after_ns: int) -> None:
        """Take back what would be complete after this time."""
        if not self.flights:
            self._before = b""
            return
        left = [each for each in self.characters() if each[0] <= after_ns]
        self.flights.clear()
        self._taken = 0
        self._before = b""
        if left:
            self.flights.append(Flight(tuple(at_ns for at_ns, _ in left), bytes(byte for _, byte in left)))
        self.wake_on(self.wake_byte, self._mark)
        self._due_changed()

    def take(self, now_ns: int) -> list[Flight]:
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
        while self._wakes and self._wakes[0] <= now_ns:
            self._wakes.popleft()
        self._find_next()
        return come

    def _find_next(self) -> None:
        next_ns: int = FOREVER
        if self.wake_byte is not None:
            if self._wakes:
                next_ns = self._wakes[0]
        elif self.flights:
            next_ns = self.flights[0].times_ns[self._taken]
        self.next_ns = SimTimeNs(next_ns)


@lru_cache(maxsize=4)
def flight_of(characters: tuple[HeardCharacter, ...]) -> Flight:
    """Make a flight of characters; cached, because all receivers on a line hear the same."""
    return Flight(tuple(each.at_ns for each in characters), bytes(each.byte for each in characters))


@lru_cache(maxsize=4)
def heard(start_ns: int, data: bytes, sent_baud: int, baud: int) -> Flight | None:
    """Characters that a receiver makes of bytes on a line; cached: all receivers on it make the same."""
    if sent_baud == baud:
        times_ns = tuple(start_ns + character_ns(i + 1, baud) for i in range(len(data)))
        return Flight(times_ns, data) if data else None
    one_ns = character_ns(1, baud)
    sampled = resample(data, sent_baud, baud)
    times_ns = tuple(start_ns + each.offset_ns + one_ns for each in sampled)
    return Flight(times_ns, bytes(each.byte for each in sampled)) if sampled else None


@lru_cache(maxsize=4)
def _wakes(flight: Flight, byte: int, mark: int | None, before: bytes) -> tuple[int, ...]:
    """Times at which that byte is complete; with a mark, only where it may be an end behind it
    (``hil.vocab.firmware.Uart.wake_on``). ``before``: the bytes before the flight."""
    stream = before + flight.data
    places = range(len(before), len(stream))
    return tuple(
        at_ns
        for at_ns, place in zip(flight.times_ns, places, strict=True)
        if stream[place] == byte
        and (mark is None or place < 2 or _is_end(stream[place - 2 : place], byte, mark))
    )


def _is_end(before: bytes, byte: int, mark: int) -> bool:
    """Whether that byte ends what the mark has announced, two bytes standing before it."""
    return before[1] == mark or (before[0] == mark and before[1] != byte)
