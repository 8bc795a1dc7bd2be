"""Long files of the SAC's companion: rows as a queue's file has them, as many as one likes, in order.

Source: SAC user manual, companion app: files make the board's queue limitless.
"""

from typing import NamedTuple

from device_profiles.sac.companion_files import ROWS, Row, is_cut_row, read_row, split_lines
from device_profiles.sac.typed_text import f_of
from hil.vocab.dialogue import Refusal

MOST_BYTES = 64 << 20
"""Length of a file: a million rows."""
_MOST_TOLD = 50


class LongFile(NamedTuple):
    """Content of a file: its rows in order, and the line of each."""

    name: str
    rows: list[Row]
    lines: list[int]

    def check(self, steps_per_rev: int) -> None:
        """Check the rows' velocities for a motor.

        Raises:
            Refusal: RPM and cycle of a row cannot belong together.
        """
        refuse(
            [
                f"{self.name}:{line}:1: RPM {row.rpm} and cycle {row.cycle_us} contradict each other"
                f" at {steps_per_rev} steps a turn; write cycle {f_of(steps_per_rev) // row.rpm}"
                for row, line in zip(self.rows, self.lines, strict=True)
                if not row.is_possible(steps_per_rev)
            ]
        )


def read_long_file(data: bytes, file: str) -> LongFile:
    """Read the rows of a long file. Positions count through the file, or from 1 to 30 again and again, as
    where saved queues were put one behind the other.

    Raises:
        Refusal: a line ``file:line:column: what; remedy`` for each problem, the first 50 of them.
    """
    problems: list[str] = []
    rows: list[Row] = []
    at: list[int] = []
    lines, is_whole = split_lines(data, file, MOST_BYTES)
    for number, line in enumerate(lines, 1):
        if not line.strip():
            if number < len(lines):
                problems.append(f"{file}:{number}:1: an empty line; take it out")
            continue
        if number == len(lines) and not is_whole and is_cut_row(line):
            problems.append(
                f"{file}:{number}:{len(line) + 1}: the file ends in the middle of this row;"
                " it was cut off, copy it again"
            )
            continue
        row = read_row(line, f"{file}:{number}", problems, most_rows=MOST_BYTES)
        at.append(number)
        rows.append(row or _NO_ROW)
        place = len(rows)
        if row and row.position not in (place, (place - 1) % ROWS + 1):
            wanted = f"{place}" if place <= ROWS else f"{place} or {(place - 1) % ROWS + 1}"
            problems.append(
                f"{file}:{number}:1: position {row.position} in row {place}; rows run in the file's order:"
                f" write {wanted}"
            )
    if not rows and not problems:
        problems.append(f"{file}:1:1: there are no rows")
    refuse(problems)
    return LongFile(file, rows, at)


def refuse(problems: list[str]) -> None:
    """Refuse if there are problems, and tell the first of them.

    Raises:
        Refusal: there are some.
    """
    if not problems:
        return
    rest = len(problems) - _MOST_TOLD
    more = [f"and {rest:,} more"] if rest > 0 else []
    raise Refusal("\n".join([*problems[:_MOST_TOLD], *more]))


_NO_ROW = Row(*[0] * len(Row._fields))
