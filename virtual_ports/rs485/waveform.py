"""What a receiver makes of a line that several drive, or one drives wrongly. Exact, in nanoseconds.

Decision: where no driver is on, the bias holds the line idle (1). Drivers that agree make its level; where
they do not, the difference is too small for a receiver, which then reads 1 (fail-safe). So the line is low
only where every driver that is on drives low.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

_NS_PER_S = 10**9
_BITS = 10  # start, eight data, stop


class Drive(NamedTuple):
    """A driver that is on from ``on_ns`` to ``off_ns``, and sends ``data`` from ``start_ns``."""

    start_ns: int
    data: bytes
    baud: int
    on_ns: int
    off_ns: int
    is_inverted: bool = False
    """Its two wires are swapped: it drives 0 for 1."""


class Character(NamedTuple):
    """One that a receiver read, when its stop bit was sampled to the end."""

    at_ns: int
    byte: int
    is_framing_error: bool


def low_times(drive: Drive) -> list[tuple[int, int]]:
    """When a driver drives low, from and to, ascending."""
    edges: list[tuple[int, int]] = []
    level, since = 1, drive.start_ns
    for index, byte in enumerate(drive.data):
        for bit, new in enumerate((0, *(byte >> place & 1 for place in range(8)), 1)):
            if new != level:
                at_ns = drive.start_ns + (index * _BITS + bit) * _NS_PER_S // drive.baud
                if new:
                    edges.append((since, at_ns))
                level, since = new, at_ns
    if not drive.is_inverted:
        return edges
    ends = [drive.on_ns, *(at_ns for edge in edges for at_ns in edge), drive.off_ns]
    return [(ends[i], ends[i + 1]) for i in range(0, len(ends), 2) if ends[i] < ends[i + 1]]


def low_line(drives: Sequence[Drive]) -> list[tuple[int, int]]:
    """When the line is low, from and to, ascending."""
    changes: list[tuple[int, int, int]] = []  # time, change of drivers on, change of drivers low
    for drive in drives:
        changes += [(drive.on_ns, 1, 0), (drive.off_ns, -1, 0)]
        for from_ns, to_ns in low_times(drive):
            changes += [(from_ns, 0, 1), (to_ns, 0, -1)]
    changes.sort()
    lows: list[tuple[int, int]] = []
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
            if since < at_ns:
                lows.append((since, at_ns))
            since = -1
    return lows


def inverted(lows: Sequence[tuple[int, int]], from_ns: int, to_ns: int) -> list[tuple[int, int]]:
    """The same between two times as a station with swapped wires sees it."""
    ends = [from_ns, *(at_ns for low in lows for at_ns in low), to_ns]
    return [(ends[i], ends[i + 1]) for i in range(0, len(ends), 2) if ends[i] < ends[i + 1]]


def read(lows: Sequence[tuple[int, int]], baud: int) -> Iterator[Character]:
    """What a UART at ``baud`` makes of it: it waits for a falling edge, checks the start bit's middle, takes
    each bit in its middle, and looks for the next edge after the stop bit's middle."""
    ready_ns = -1
    index = 0
    while index < len(lows):
        start_ns = lows[index][0]
        if start_ns < ready_ns:
            index += 1
            continue
        levels = []
        at = index
        for bit in range(_BITS):
            sample_ns = start_ns + (2 * bit + 1) * _NS_PER_S // (2 * baud)
            while at < len(lows) and lows[at][1] <= sample_ns:
                at += 1
            levels.append(0 if at < len(lows) and lows[at][0] <= sample_ns else 1)
        if levels[0]:  # a glitch
            ready_ns = start_ns + _NS_PER_S // (2 * baud)
        else:
            byte = sum(level << place for place, level in enumerate(levels[1:9]))
            yield Character(start_ns + _BITS * _NS_PER_S // baud, byte, levels[9] == 0)
            ready_ns = start_ns + 19 * _NS_PER_S // (2 * baud)
        index += 1
