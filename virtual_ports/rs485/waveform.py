"""Waveform of a line that several drive, or one drives wrongly, and its reading. Exact, in ns.

Decision: where no driver is on, the bias holds the line idle (1). Drivers that agree make its level; where
they do not, the difference is too small for a receiver, which then reads 1 (fail-safe). So the line is low
only where every driver that is on drives low.

Everything takes a span of time, so that a line can be read piece by piece, as it comes.
"""

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import NamedTuple

from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.vocab.segment import HeardCharacter

_NS_PER_S = 10**9

Lows = list[tuple[int, int]]
"""Spans in which a line is low, ascending; two never touch."""


class Driving(NamedTuple):
    """Driver that is on from ``on_ns`` to ``off_ns``, and sends ``data`` from ``start_ns``."""

    start_ns: int
    data: bytes
    baud: int
    on_ns: int
    off_ns: int
    is_inverted: bool = False
    """True if its two wires are swapped: it drives 0 for 1."""
    sent_format: LineFormat | None = None
    """Format of its characters, where it is not the line's."""


@cache
def _lows_of_bytes(line_format: LineFormat) -> tuple[int, ...]:
    """The bits of each byte's character that are low, the first one in the lowest place."""
    levels = (line_format.levels(byte) for byte in range(256))
    return tuple(sum((not level) << at for at, level in enumerate(each)) for each in levels)


def low_line(
    drives: Iterable[Driving], from_ns: int, to_ns: int, line_format: LineFormat = EIGHT_N_1
) -> Lows:
    alike: dict[tuple[object, ...], list[Driving]] = {}
    for drive in drives:
        if drive.on_ns < to_ns and drive.off_ns > from_ns:
            what = (drive.start_ns, drive.baud, len(drive.data), *drive[3:])
            alike.setdefault(what, []).append(drive)
    changes: list[tuple[int, int, int]] = []  # time, change of drivers on, change of drivers low
    for group in alike.values():
        changes += [(max(group[0].on_ns, from_ns), 1, 0), (min(group[0].off_ns, to_ns), -1, 0)]
        for low_ns, high_ns in _low_times(group, from_ns, to_ns, group[0].sent_format or line_format):
            changes += [(low_ns, 0, 1), (high_ns, 0, -1)]
    changes.sort()
    lows: Lows = []
    on = low = 0
    since = -1
    for index, (at_ns, more_on, more_low) in enumerate(changes):
        on += more_on
        low += more_low
        if index + 1 < len(changes) and changes[index + 1][0] == at_ns:
            continue
        is_low = on > 0 and low == on
        if is_low and since < 0:
            since = at_ns
        elif not is_low and since >= 0:
            lows.append((since, at_ns))
            since = -1
    return lows


def _low_times(group: Sequence[Driving], from_ns: int, to_ns: int, line_format: LineFormat) -> Lows:
    """Times at which drivers that begin and end together, at one baud, all drive low, between two times."""
    start_ns, data, baud, on_ns, off_ns, is_inverted, _ = group[0]
    size, lows_of = line_format.bits, _lows_of_bytes(line_format)
    first = max((from_ns - start_ns) * baud // _NS_PER_S // size, 0)
    end = max(min((to_ns - start_ns) * baud // _NS_PER_S // size + 1, len(data)), first)
    different = {drive.data[first:end] for drive in group}
    edges: Lows = []
    for index in range(end - first):
        if is_inverted:  # the others' highs are lows
            bits = 0
            for part in different:
                bits |= lows_of[part[index]]
        else:
            bits = -1
            for part in different:
                bits &= lows_of[part[index]]
        place = (first + index) * size
        while bits:
            zeros = (bits & -bits).bit_length() - 1
            bits >>= zeros
            ones = (~bits & bits + 1).bit_length() - 1
            bits >>= ones
            place += zeros
            edge = start_ns + place * _NS_PER_S // baud, start_ns + (place + ones) * _NS_PER_S // baud
            edges.append(edge)
            place += ones
    if is_inverted:
        edges = inverted(edges, on_ns, off_ns)
    return [
        (max(low_ns, from_ns), min(high_ns, to_ns))
        for low_ns, high_ns in edges
        if low_ns < to_ns and high_ns > from_ns
    ]


def inverted(lows: Sequence[tuple[int, int]], from_ns: int, to_ns: int) -> Lows:
    """Lows between two times as a station with swapped wires sees them."""
    ends = [from_ns, *(at_ns for low in lows for at_ns in low), to_ns]
    return [(ends[i], ends[i + 1]) for i in range(0, len(ends), 2) if ends[i] < ends[i + 1]]


def joined(lows: Lows, more: Lows) -> Lows:
    """Join a line and how it goes on."""
    if lows and more and lows[-1][1] == more[0][0]:
        return [*lows[:-1], (lows[-1][0], more[0][1]), *more[1:]]
    return lows + more


def without(lows: Lows, from_ns: int, to_ns: int) -> Lows:
    """Lows of a line as a receiver sees it that is off between two times."""
    kept = []
    for low_ns, high_ns in lows:
        if low_ns < from_ns:
            kept.append((low_ns, min(high_ns, from_ns)))
        if high_ns > to_ns:
            kept.append((max(low_ns, to_ns), high_ns))
    return kept


def read(
    lows: Lows,
    baud: int,
    ready_ns: int,
    known_ns: int,
    until_ns: int,
    line_format: LineFormat = EIGHT_N_1,
) -> tuple[list[HeardCharacter], int]:
    """Read the characters of a line as a UART at ``baud`` does that was ready for a start bit at
    ``ready_ns``: it waits for a falling edge, checks the start bit's middle, takes each bit in its middle,
    and looks for the next edge after the first stop bit's middle.

    Answers the characters that are complete by ``until_ns``; and the time from which a later reading, of a
    line that may differ from this one from ``known_ns`` on, has to begin to tell those after ``known_ns``.
    """
    characters: list[HeardCharacter] = []
    again_ns = ready_ns
    is_known = True
    for at_ns, next_ns, character in _readings(lows, baud, ready_ns, line_format):
        if is_known:
            is_over = character.at_ns <= known_ns if character else next_ns < known_ns
            is_known = is_over and at_ns < known_ns
            again_ns = next_ns if is_known else min(at_ns, known_ns)
        if character:
            if character.at_ns > until_ns:
                break
            characters.append(character)
    else:
        if is_known:
            again_ns = max(again_ns, known_ns)
    return characters, again_ns


def _readings(
    lows: Lows, baud: int, ready_ns: int, line_format: LineFormat
) -> Iterator[tuple[int, int, HeardCharacter | None]]:
    """Iterate over each falling edge that a UART tries as a start bit: when it was, when the UART looks for
    the next, and what character it began, None if it was a glitch."""
    stop = line_format.bits - line_format.stop_bits
    samples_ns = [(2 * bit + 1) * _NS_PER_S // (2 * baud) for bit in range(stop + 1)]
    one_ns = line_format.bits * _NS_PER_S // baud
    has_parity, data_bits = line_format.has_parity, line_format.data_bits
    index, end = bisect_left(lows, (ready_ns,)), len(lows)
    while index < end:
        start_ns = lows[index][0]
        if start_ns < ready_ns:
            index += 1
            continue
        levels = 0
        at = index
        for bit, sample_ns in enumerate(samples_ns):
            sample_ns += start_ns
            while at < end and lows[at][1] <= sample_ns:
                at += 1
            if at == end or lows[at][0] > sample_ns:
                levels |= 1 << bit
                if not bit:
                    break
        if levels == 1:
            ready_ns = start_ns + samples_ns[0]
            yield start_ns, ready_ns, None
        else:
            ready_ns = start_ns + samples_ns[-1]
            byte = levels >> 1 & (1 << data_bits) - 1
            is_odd = has_parity and levels >> 1 + data_bits & 1 != line_format.parity_bit(byte)
            yield start_ns, ready_ns, HeardCharacter(start_ns + one_ns, byte, not levels >> stop, is_odd)
        index += 1
