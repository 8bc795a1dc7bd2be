"""Lines of a bench's log that are wanted, from the file of its recording, which may still grow."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from hil.compose.log_lines import LogLines
from hil.recorded.said_lines import LEVELS, SaidLine, SaidLines

_KEPT = 10_000
"""Lines more than are wanted, at which the oldest are dropped."""


class SaidWish(NamedTuple):
    """Choice of lines. ``most``: the last so many; 0: all."""

    device: str | None = None
    level: str = LEVELS[0]
    most: int = 0

    def wants(self, line: SaidLine) -> bool:
        """True if a line is wanted. Bytes that are no text are wanted of a device only."""
        if LEVELS.index(line.level) < LEVELS.index(self.level):
            return False
        return line.is_of(self.device) if self.device else line.kind != "bytes"


class SaidReading:
    """Reading of a recording, as far as it is there.

    Raises:
        OSError, InputLogError: as ``LogLines``.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = LogLines(path)
        self.said = SaidLines()

    def close(self) -> None:
        """Close the file."""
        self._file.__exit__()

    def more(self) -> Iterator[SaidLine]:
        """Read what is there since the last call."""
        for line in self._file.more():
            yield from self.said.add(line)

    def latest(self, wish: SaidWish, *, goes_on: bool) -> list[SaidLine]:
        """Read all that is there; answers the wanted lines in the order of time. ``goes_on``: ``more`` reads
        the rest, so that a text without an end may not be a line yet."""
        kept = list[SaidLine]()
        places = dict[int, int]()
        for each in self.more():
            if not wish.wants(each):
                continue
            if each.number and each.number in places:
                kept[places[each.number]] = each
                continue
            places[each.number] = len(kept)
            kept.append(each)
            if wish.most and len(kept) > wish.most + _KEPT:
                kept.sort(key=lambda line: line.at_ns)
                kept, places = kept[-wish.most :], {}
        kept += filter(wish.wants, self.said.silent(self.said.end_ns if goes_on else None))
        kept.sort(key=lambda line: line.at_ns)
        return kept[-wish.most :] if wish.most else kept
