"""Rows of a path in a run's text: how long each takes, how it begins, and where the axes are at its end."""

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import NamedTuple

from hil.config.document import Document, Finding, KeyPath, Spot
from hil.runs.run_document import AxisRules, TimedPath
from hil.vocab.path import DEG_PER_S, PathPiece
from hil.vocab.time import NS_PER_S

ROWS = 100_000
"""Maximum number of rows of a path, and of all paths of a run, repetitions counted."""
LONGEST_S = 86_400.0
FARTHEST_DEG = 1e6
SLACK = 1e-3
"""Share by which limits may be exceeded: angles and times of rows are rounded."""
ROUNDED_DEG = 2e-6
"""Distance that the rounding of a row's angles may make. An angle with six decimals is 5e-7 off."""
NAMED = 20
"""Maximum number of problems of one path that are listed."""


class PathRow(NamedTuple):
    """Piece of a path: all axes go in a straight line with one acceleration. ``begin`` is the speed at its
    beginning in shares of its mean speed: 0 is from rest, 1 constant, 2 to rest."""

    duration_ns: int
    begin: float
    end_deg: Sequence[float]


class PathReading:
    """Rows of a path, read and compared with the limits of its axes, and what is wrong with them."""

    def __init__(
        self,
        path: TimedPath,
        place: KeyPath,
        document: Document,
        begin_deg: Sequence[float] | None,
        rules: Mapping[str, AxisRules],
    ) -> None:
        """Read the rows. ``begin_deg``: where the axes are before; None: that is not known, and the rows are
        not compared with the limits."""
        self._path, self._place, self._block = path, place, document.blocks.get((*place, "rows"))
        self.findings: list[Finding] = []
        self._numbers: list[int] = []
        """Line of each row in the path's text, from 0 on."""
        self.rows = list(self._read())
        if not self.findings and begin_deg is not None:
            self._check(begin_deg, [rules[name] for name in path.axes])
        if len(self.findings) > NAMED:
            rest = len(self.findings) - NAMED
            del self.findings[NAMED:]
            self.findings.append(Finding((*place, "rows"), f"and {rest} more", "see those above"))

    def pieces(self, begin_deg: Sequence[float]) -> list[list[PathPiece]]:
        """Pieces of the set-point of each axis, in the order of the path's axes."""
        pieces: list[list[PathPiece]] = [[] for _ in begin_deg]
        here = begin_deg
        for duration_ns, begin, end_deg in self.rows:
            duration_s = duration_ns / NS_PER_S
            for made, from_deg, to_deg in zip(pieces, here, end_deg, strict=True):
                mean = (to_deg - from_deg) / duration_s
                made.append(
                    PathPiece(duration_ns, from_deg, mean * begin, 2 * mean * (1 - begin) / duration_s)
                )
            here = end_deg
        return pieces

    # ---- what is wrong ----

    def _read(self) -> Iterator[PathRow]:
        columns = 2 + len(self._path.axes)
        lines = self._path.rows.splitlines()
        if len(lines) > ROWS:
            self._find(ROWS, 0, f"there are more than {ROWS} rows", "make two runs of it")
            return
        for number, line in enumerate(lines):
            words = line.split()
            if not words:
                continue
            if len(words) != columns:
                what = (
                    f"{len(words)} numbers; a row has {columns}: seconds, begin, {', '.join(self._path.axes)}"
                )
                self._find(number, 0, what, "write all of them")
                continue
            try:
                values = [float(word) for word in words]
            except ValueError:
                wrong = next(at for at, word in enumerate(words) if not _is_number(word))
                self._find(number, wrong, f"{words[wrong][:40]!r} is no number", "write a number", line)
                continue
            if (found := self._wrong_value(values)) is None:
                self._numbers.append(number)
                yield PathRow(round(values[0] * NS_PER_S), values[1], values[2:])
            else:
                self._find(number, *found, line)

    @staticmethod
    def _wrong_value(values: Sequence[float]) -> tuple[int, str, str] | None:
        if not 1e-6 <= values[0] <= LONGEST_S:
            return 0, f"{values[0]:g} s is no time of a row", f"it takes 0.000001 to {LONGEST_S:g} s"
        if not 0 <= values[1] <= 2:
            return 1, f"it begins with {values[1]:g} times its mean speed", "write 0 to 2"
        for at, angle in enumerate(values[2:], 2):
            if not (isfinite(angle) and abs(angle) <= FARTHEST_DEG):
                return at, f"{angle:g} is no angle", f"write at most {FARTHEST_DEG:g} deg"
        return None

    def _check(self, begin_deg: Sequence[float], rules: Sequence[AxisRules]) -> None:
        """Compare the rows with the axes' limits: ranges, speeds, accelerations, and steps of the speed."""
        for axis, (name, limits) in enumerate(zip(self._path.axes, rules, strict=True)):
            most, steepest = limits.velocity_rpm * DEG_PER_S, limits.acceleration_rpm_per_s * DEG_PER_S
            jump = steepest * self._path.corner_s
            at_deg, before = begin_deg[axis], 0.0
            for number, (duration_ns, begin, end_deg) in enumerate(self.rows):
                duration_s, to_deg = duration_ns / NS_PER_S, end_deg[axis]
                mean = (to_deg - at_deg) / duration_s
                slack = ROUNDED_DEG / duration_s
                first, last = mean * begin, mean * (2 - begin)
                what = ""
                if not limits.min_deg <= to_deg <= limits.max_deg:
                    what = f"{to_deg:g} deg; its range is {limits.min_deg:g} to {limits.max_deg:g}"
                elif (speed := max(abs(first), abs(last))) > most * (1 + SLACK) + slack:
                    what = f"{speed / DEG_PER_S:.4g} rpm; its limit is {limits.velocity_rpm:g}"
                elif (steep := abs(last - first) / duration_s) > steepest * (
                    1 + SLACK
                ) + 2 * slack / duration_s:
                    limit = limits.acceleration_rpm_per_s
                    what = f"{steep / DEG_PER_S:.4g} rpm/s; its limit is {limit:g}"
                elif (step := abs(first - before)) > jump * (1 + SLACK) + 2 * slack:
                    what = f"its speed changes at once by {step / DEG_PER_S:.4g} rpm: {self._allowed(jump)}"
                if what:
                    self._find(
                        self._numbers[number], 2 + axis, f"{name}: {what}", "take more time, or other places"
                    )
                at_deg, before = to_deg, last
            if abs(before) > jump * (1 + SLACK) + 2 * ROUNDED_DEG * NS_PER_S / self._last_ns:
                what = f"{name}: it ends with {abs(before) / DEG_PER_S:.4g} rpm: {self._allowed(jump)}"
                self._find(self._numbers[-1], 2 + axis, what, "end at rest: begin the last row with 2")

    def _allowed(self, jump: float) -> str:
        return f"`corner_s` allows {jump / DEG_PER_S:.4g}"

    @property
    def _last_ns(self) -> int:
        return self.rows[-1].duration_ns if self.rows else NS_PER_S

    def _find(self, row: int, word: int, what: str, remedy: str, line: str | None = None) -> None:
        spot = None
        if self._block:
            if line is None:
                lines = self._path.rows.splitlines()
                line = lines[row] if row < len(lines) else ""
            spot = Spot(self._block.line + row, self._block.column + _column(line, word))
        message = what if spot else f"row {row + 1}: {what}"
        self.findings.append(Finding((*self._place, "rows"), message, remedy, spot=spot))


def _column(line: str, word: int) -> int:
    """Characters before a word of a line."""
    at = 0
    for each in line.split()[: word + 1]:
        begin = line.index(each, at)
        at = begin + len(each)
    return at - len(each) if line.split()[: word + 1] else 0


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
