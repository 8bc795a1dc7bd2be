"""Flights: characters on a line, with the times at which a receiver has them."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from hil.vocab.framing import Framing, Item
from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.vocab.segment import HeardCharacter
from hil.wire.serial_line import Sampled, character_ends_ns, character_ns, resample


@dataclass(eq=False, slots=True)
class Flight:
    """Characters on the line, at least one. All receivers of a burst share it; equal only to itself, so that
    it is found quickly."""

    times_ns: tuple[int, ...]
    """Times at which each is complete, ascending."""
    data: bytes
    packets: Sequence[Item] | None = None
    """Packets of the bytes by the line's framing, if they are whole packets for everybody."""
    framing: Framing | None = None
    """Framing of the line."""
    spoiled: frozenset[int] = frozenset()
    """Times of characters with a wrong stop bit or a wrong parity."""

    tail: bytes = b""
    """Last two bytes of the flight, or fewer."""

    def __post_init__(self) -> None:
        self.tail = self.data[-2:]

    def part(self, first: int, end: int) -> "Flight":
        return Flight(self.times_ns[first:end], self.data[first:end])

    def characters(self) -> Iterator[tuple[int, int]]:
        return zip(self.times_ns, self.data, strict=True)


@lru_cache(maxsize=4)
def flight_of(characters: tuple[HeardCharacter, ...]) -> Flight:
    """Make a flight of characters; cached, because all receivers on a line hear the same."""
    return Flight(
        tuple(each.at_ns for each in characters),
        bytes(each.byte for each in characters),
        spoiled=frozenset(each.at_ns for each in characters if each.is_framing_error or each.is_parity_error),
    )


@lru_cache(maxsize=4)
def heard(
    start_ns: int,
    data: bytes,
    sent_baud: int,
    baud: int,
    framing: Framing | None = None,
    line_format: LineFormat = EIGHT_N_1,
    sent_format: LineFormat | None = None,
) -> Flight | None:
    """Characters that a receiver makes of bytes on a line, of this framing; cached: all receivers on it make
    the same. ``sent_format``: the sender's, by default the receiver's."""
    bits = line_format.bits
    sent_format = sent_format or line_format
    if sent_baud == baud and sent_format is line_format:
        times_ns = tuple(character_ends_ns(start_ns, len(data), baud, bits))
        return Flight(times_ns, data, framing=framing) if data else None
    one_ns = character_ns(1, baud, bits)
    sampled = resample(data, sent_baud, baud, sent_format, line_format)
    if not sampled:
        return None
    times_ns = tuple(start_ns + each.offset_ns + one_ns for each in sampled)
    wrong = (at_ns for at_ns, each in zip(times_ns, sampled, strict=True) if _is_wrong(each))
    return Flight(times_ns, bytes(each.byte for each in sampled), spoiled=frozenset(wrong))


@lru_cache(maxsize=4)
def end_times(framing: Framing, flight: Flight, before: bytes | None) -> tuple[int, ...]:
    """Times of the characters that may be ends; cached: all receivers on a line hear the same."""
    return tuple(flight.times_ns[place] for place in framing.ends(flight.data, before))


def _is_wrong(sampled: Sampled) -> bool:
    return sampled.framing_error or sampled.parity_error


def joined(
    pieces: Iterable[tuple[int, bytes]], baud: int, bits: int = EIGHT_N_1.bits
) -> list[tuple[int, bytes]]:
    """Join pieces that follow each other without a gap: a receiver sees one stream. ``bits``: of a
    character."""
    joined: list[tuple[int, bytes]] = []
    end_ns = -1
    for start_ns, data in pieces:
        if joined and start_ns <= end_ns:
            joined[-1] = (joined[-1][0], joined[-1][1] + data)
        else:
            joined.append((start_ns, data))
        end_ns = start_ns + character_ns(len(data), baud, bits)
    return joined
