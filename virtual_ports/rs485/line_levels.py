"""Levels of a segment's wire as they were, for pictures of it."""

from hil.vocab.line_format import LineFormat
from virtual_ports.rs485.waveform import Driving, low_line


class LineLevels:
    """Levels of a line from ``from_ns`` on, by what drives it. ``waveform`` says what contention makes of it.

    Not drawn: the parity bit that noise leaves as it was meant.
    """

    def __init__(self, from_ns: int, line_format: LineFormat) -> None:
        self._until_ns = from_ns
        self._format = line_format
        self._drives: list[Driving] = []
        self._level = 1

    def add(self, drive: Driving) -> None:
        """Add what begins to drive the line now."""
        self._drives.append(drive)

    def drain(self, until_ns: int, *, is_held: bool) -> list[tuple[int, int]]:
        """Edges since the last call, up to a time that has come: (at_ns, level). ``is_held``: a driver that
        is stuck holds the line high."""
        from_ns, self._until_ns = self._until_ns, until_ns
        lows = [] if is_held else low_line(self._drives, from_ns, until_ns, self._format)
        self._drives = [drive for drive in self._drives if drive.off_ns > until_ns]
        edges: list[tuple[int, int]] = []
        if not self._level and not (lows and lows[0][0] == from_ns):
            edges.append((from_ns, 1))
            self._level = 1
        for low_ns, high_ns in lows:
            if self._level:
                edges.append((low_ns, 0))
            self._level = int(high_ns < until_ns)
            if self._level:
                edges.append((high_ns, 1))
        return edges
