"""Checks of an input log: lines that say what stands before them, so that damage is found, and totals are
known without reading all.

A check line has ``check``, the CRC-32 of all bytes of the text before it; ``lines``, the number of lines
before it; ``inputs``, how many of them are inputs; ``faults``, how many faults of each kind have begun
(``stopped``: boards that the guard stopped), left out while there is none; ``at_ns``, the bench's time as it
was written, and ``wall``, the date then, left out where there is no clock. There is one for each second of
simulated time that has lines. The last line, ``"end":true``, is one too and says ``why``.
"""

import json
import zlib
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol

from hil.sim.inputs import Inject, Logged, Stopped, quoted
from hil.vocab.time import NS_PER_S

STOPPED, FULL, UNWRITABLE = "stopped", "full", "unwritable"
ENDS = {
    STOPPED: "",
    FULL: "its room was used, and the bench went on",
    UNWRITABLE: "it could not be written any more, and the bench went on",
}
"""Reasons of an end line, with their meaning for people where the run did not end with its log."""
GUARD_STOP = "stopped"
"""Kind under which stops of boards by the guard are counted."""


def without_checks(text: str) -> list[str]:
    """Lines of a log as version 2 has them, which may be changed without a check that finds it."""
    lines = text.replace('"version":3', '"version":2', 1).splitlines(keepends=True)
    is_ended = '{"end":true,' in lines[-1]
    kept = (line for line in lines if '"check":' not in line and '"event":' not in line)
    return [*kept, *(['{"end":true}\n'] if is_ended else [])]


class LineSink(Protocol):
    """Destination of lines."""

    def write(self, text: str, /) -> object:
        """Append a text to the destination."""


@dataclass
class LogTotals:
    """Totals of what was written so far. ``last_ns``: the latest time in a line."""

    crc: int = 0
    lines: int = 0
    inputs: int = 0
    last_ns: int = 0
    faults: Counter[str] = field(default_factory=Counter)


class LogChecks:
    """Destination of a log's lines, which puts checks between them. ``clock``: as ``InputLogWriter`` has
    it."""

    def __init__(self, file: LineSink, clock: Callable[[], tuple[int, str]] | None = None) -> None:
        self._file, self._clock = file, clock
        self._totals = LogTotals()
        self._pieces: list[str] = []
        self._second = 0
        self._has_fresh = False

    @property
    def lines(self) -> int:
        """Number of lines so far."""
        return self._totals.lines

    def write_line(self, line: str) -> None:
        """Write a line, with its end, that is neither an input nor sent."""
        self._pieces.append(line)
        self._totals.lines += 1
        self.hand_on()

    def add(self, at_ns: int, line: str, logged: Logged | None) -> None:
        """Add a line, with its end, of an input or of what was sent; ``hand_on`` writes it."""
        if (second := at_ns // NS_PER_S) > self._second:
            if self._has_fresh:
                self.check()
            self._second = second
        self._pieces.append(line)
        self._has_fresh = True
        totals = self._totals
        totals.lines += 1
        totals.last_ns = max(totals.last_ns, at_ns)
        if logged is not None:
            totals.inputs += 1
            if isinstance(logged.input, Inject):
                totals.faults[logged.input.kind] += 1
            elif isinstance(logged.input, Stopped):
                totals.faults[GUARD_STOP] += 1

    def hand_on(self) -> None:
        """Write what was added."""
        if self._pieces:
            text = "".join(self._pieces)
            self._pieces.clear()
            self._totals.crc = zlib.crc32(text.encode(), self._totals.crc)
            self._file.write(text)

    def check(self) -> None:
        """Write a check."""
        self.write_line(f"{{{self._words()}}}\n")
        self._has_fresh = False

    def check_if_due(self) -> None:
        """Write a check if the second of the last lines is over."""
        if self._has_fresh and self._clock and self._clock()[0] // NS_PER_S > self._second:
            self.check()

    def end(self, why: str) -> None:
        """Write the end line."""
        self.write_line(f'{{"end":true,"why":{quoted(why)},{self._words()}}}\n')

    def mark(self) -> LogTotals:
        """Totals of what is written, for ``back_to``."""
        return replace(self._totals, faults=Counter(self._totals.faults))

    def back_to(self, totals: LogTotals) -> None:
        """Forget what was written since a mark: it is not in the file."""
        self._totals = totals
        self._pieces.clear()

    def _words(self) -> str:
        self.hand_on()
        totals, wall = self._totals, ""
        at_ns = totals.last_ns
        if self._clock:
            now_ns, date = self._clock()
            at_ns, wall = max(at_ns, now_ns), f',"wall":"{date}"'
        totals.last_ns = at_ns
        counted = json.dumps(totals.faults, separators=(",", ":"))
        faults = f',"faults":{counted}' if totals.faults else ""
        numbers = f'"check":{totals.crc},"lines":{totals.lines},"inputs":{totals.inputs}'
        return f'"at_ns":{at_ns},{numbers}{faults}{wall}'
