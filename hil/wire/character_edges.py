"""Edges of the characters on a serial line, at their exact times."""

from collections.abc import Iterator
from functools import cache

from hil.vocab.line_format import EIGHT_N_1, LineFormat

_NS_PER_S = 10**9


@cache
def _edges_of_bytes(line_format: LineFormat) -> tuple[tuple[tuple[int, int], ...], ...]:
    """Edges of each byte's character, as (bit, level); the line is high before it and at its end."""
    every = []
    for byte in range(256):
        levels = line_format.levels(byte)
        before = (1, *levels[:-1])
        pairs = enumerate(zip(before, levels, strict=True))
        every.append(tuple((bit, level) for bit, (was, level) in pairs if was != level))
    return tuple(every)


def character_edges(
    start_ns: int, data: bytes, baud: int, line_format: LineFormat = EIGHT_N_1
) -> Iterator[tuple[int, int]]:
    """Edges of bytes that stand back to back from ``start_ns`` on, as (at_ns, level); the line is idle, high,
    before and after. Times are rounded down, each once."""
    edges, bits = _edges_of_bytes(line_format), line_format.bits
    for index, byte in enumerate(data):
        first = index * bits
        for bit, level in edges[byte]:
            yield start_ns + (first + bit) * _NS_PER_S // baud, level
