"""Numbers in the lines that a sketch prints, as the Arduino IDE's plotter reads them: with commas, spaces or
tabs between, each with a name and a colon before it or without. Pure.

The terminal of the page has the same rules.

Source: "Using the Serial Plotter Tool" of Arduino's documentation.
"""

import math
import re

_NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_ITEM = re.compile(rf"(?:([^\s,:]+):[ \t]*)?({_NUMBER})(?:[\s,]+|$)")
MOST_LINE_BYTES = 1024
"""Length from which on a line without an end is none."""
MOST_NAMES = 16
"""Maximum number of series: more are other text with a number behind a colon."""


def numbers_in(line: str) -> dict[str, float]:
    """Numbers of a line by their names; one without a name is called by its place in the line, from 1 on.
    Empty: the line has something else, too."""
    found, at, line = dict[str, float](), 0, line.strip()
    while at < len(line):
        if not (item := _ITEM.match(line, at)):
            return {}
        found[item[1] or str(len(found) + 1)] = float(item[2])
        at = item.end()
    return found


class PrintedNumbers:
    """Series of the numbers that come, from the first whole line on."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self.rows: list[tuple[float, ...]] = []
        """Time in ns since the first line, and the latest value of each name, for each line; shorter where
        names came later."""
        self.others = 0
        """Number of lines that have something else."""
        self._latest = dict[str, float]()
        self._first_ns: int | None = None
        self._held, self._is_whole = b"", False

    def add(self, at_ns: int, data: bytes) -> None:
        """Add what was printed at a time."""
        *lines, held = (self._held + data).split(b"\n")
        for line in lines:
            if self._is_whole:
                self._add_line(at_ns, line.decode("utf-8", "replace"))
            self._is_whole = True
        self._held = held
        if len(held) > MOST_LINE_BYTES:
            self.break_off()

    def break_off(self) -> None:
        """Forget the line that has begun: something of it is missing."""
        self._held, self._is_whole = b"", False

    def _add_line(self, at_ns: int, line: str) -> None:
        numbers = numbers_in(line)
        new = [name for name in numbers if name not in self.names]
        if not numbers or len(self.names) + len(new) > MOST_NAMES:
            self.others += bool(line.strip())
            return
        self.names += new
        self._latest |= numbers
        self._first_ns = at_ns if self._first_ns is None else self._first_ns
        self.rows.append((at_ns - self._first_ns, *(self._latest[name] for name in self.names)))

    def table(self) -> list[tuple[float, ...]]:
        """Rows with a value for each name, NaN before the first one."""
        width = 1 + len(self.names)
        return [row + (math.nan,) * (width - len(row)) for row in self.rows]
