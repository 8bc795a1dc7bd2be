"""A field over time in braille: each character has two columns and four rows of dots."""

from collections.abc import Sequence

COLUMNS, ROWS = 2, 4
"""Dots of a character."""
_BLANK = 0x2800
_DOTS = ((0x40, 0x04, 0x02, 0x01), (0x80, 0x20, 0x10, 0x08))
"""Bits of a character's dots, from below, of its left and its right column."""

Span = tuple[float, float] | None
"""Smallest and largest value of a column; None: there is none."""


def drawn(spans: Sequence[Span], height: int, low: float, high: float) -> list[str]:
    """Draw columns of dots, the first one to the left, as so many lines. ``low`` below ``high``: values of
    the lowest and of the highest row; what is beyond is drawn there. Neighbours are joined."""
    rows = height * ROWS
    lines = [[_BLANK] * (-(-len(spans) // COLUMNS)) for _ in range(height)]
    before: tuple[int, int] | None = None
    for column, span in enumerate(spans):
        if span is None:
            before = None
            continue
        first, last = (_row(value, rows, low, high) for value in span)
        begin, end = first, last
        if before:
            begin, end = min(first, before[1] + 1), max(last, before[0] - 1)
        before = first, last
        for row in range(begin, end + 1):
            lines[height - 1 - row // ROWS][column // COLUMNS] |= _DOTS[column % COLUMNS][row % ROWS]
    return ["".join(map(chr, line)) for line in lines]


def _row(value: float, rows: int, low: float, high: float) -> int:
    return min(max(int((value - low) / (high - low) * rows), 0), rows - 1)
