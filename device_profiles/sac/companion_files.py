"""Files of the SAC's companion program: a queue of 30 rows, and a list of 100 one-shot commands.

Source: SAC user manual, companion app; files that it saved. A queue's row has twelve numbers, each between
blanks, with commas between; lines end CR LF; a fraction under 1 has no zero before its point.
"""

import re
from typing import NamedTuple

from device_profiles.sac.typed_text import WORD, f_of
from hil.vocab.dialogue import Refusal
from hil.vocab.problem import not_text

ROWS = 30
ONE_SHOTS = 100
COLUMNS = (
    "position", "steps", "direction", "full step", "RPM", "cycle",
    "ramp", "acc", "dec", "u", "sync", "deltaT",
)  # fmt: skip
_LARGEST = (ROWS, WORD - 1, 1, 1, WORD - 1, WORD - 1, 1, 99900, 99900, 255, 1, WORD - 1)
_HUNDREDTHS = (7, 8)
LINE_BYTES = 80
FILE_BYTES = 100_000
_CUT = "it was cut off, copy it again"
_NUMBER = re.compile(r"[0-9]*\.?[0-9]+|[0-9]+\.")
_NUMBERS = re.compile(r"[0-9\s.,]+")


class Row(NamedTuple):
    """Entry of a queue; accelerations in hundredths, flags 0 or 1."""

    position: int
    steps: int
    is_ccw: int
    is_full: int
    rpm: int
    cycle_us: int
    is_linear: int
    acc_hundredths: int
    dec_hundredths: int
    extra_pulses: int
    is_sync: int
    wait_us: int

    def command(self, steps_per_rev: int) -> str:
        """Line that writes it into a board's queue. The board computes RPM and cycle from each other, and
        drops fractions: what was entered is the one that the other follows from."""
        return f"q{self.position}m{self._attributes(steps_per_rev)}s{self.is_sync}t{self.wait_us}"

    def motion(self, steps_per_rev: int) -> str:
        """Line that puts it behind what waits in a board's queue, whatever the session's defaults are."""
        return f"m{self._attributes(steps_per_rev)}{'s' * self.is_sync}" + (
            f"t{self.wait_us}" if self.wait_us else ""
        )

    def _attributes(self, steps_per_rev: int) -> str:
        is_by_rpm = f_of(steps_per_rev) // self.rpm == self.cycle_us
        velocity = f"v{self.rpm}" if is_by_rpm else f"vc{self.cycle_us}"
        return (
            f"{'-' * self.is_ccw}{self.steps}{velocity}"
            f"a{_decimal(self.acc_hundredths)}d{_decimal(self.dec_hundredths)}l{self.is_linear}"
            f"{'f' if self.is_full else 'p'}u{self.extra_pulses}"
        )

    def is_possible(self, steps_per_rev: int) -> bool:
        f = f_of(steps_per_rev)
        return f // self.rpm == self.cycle_us or f // self.cycle_us == self.rpm


class QueueFile(NamedTuple):
    """Content of a file: rows by position, and ``file:line`` of each."""

    rows: list[Row]
    where: list[str]


def read_queue(data: bytes, file: str) -> QueueFile:
    """Read the 30 rows of a queue file. Blanks may be missing, lines may end LF.

    Raises:
        Refusal: a line ``file:line:column: what; remedy`` for each problem.
    """
    problems: list[str] = []
    rows: dict[int, tuple[Row, str]] = {}
    lines, is_whole = split_lines(data, file)
    for number, line in enumerate(lines, 1):
        if not line.strip():
            if number < len(lines):
                problems.append(f"{file}:{number}:1: an empty line; take it out")
            continue
        if number == len(lines) and not is_whole and is_cut_row(line):
            problems.append(
                f"{file}:{number}:{len(line) + 1}: the file ends in the middle of this row; {_CUT}"
            )
            continue
        row = read_row(line, f"{file}:{number}", problems)
        if row is None:
            continue
        if row.position in rows:
            problems.append(f"{file}:{number}:1: position {row.position} stands twice; a queue has each once")
        rows[row.position] = (row, f"{file}:{number}")
    missing = [str(position) for position in range(1, ROWS + 1) if position not in rows]
    if missing and not problems:
        problems.append(
            f"{file}:{max(len(lines), 1)}:1: no row for position {', '.join(missing)}; a queue has {ROWS}"
        )
    if problems:
        raise Refusal("\n".join(problems))
    in_order = [rows[position] for position in range(1, ROWS + 1)]
    return QueueFile([row for row, _ in in_order], [where for _, where in in_order])


def split_lines(data: bytes, file: str, most_bytes: int = FILE_BYTES) -> tuple[list[str], bool]:
    """Split a file; answers its lines, and False if it ends within the last one.

    Raises:
        Refusal: it is too long, or no text.
    """
    if len(data) > most_bytes:
        usual = "a file of the companion has some thousand"
        raise Refusal(f"{file}:1:1: {len(data):,} bytes; {usual if most_bytes == FILE_BYTES else 'split it'}")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise Refusal(str(not_text(file, error))) from None
    lines = text.replace("\r\n", "\n").removesuffix("\n").split("\n") if text else []
    return lines, not text or text.endswith("\n")


def is_cut_row(line: str) -> bool:
    """True if a line without an end stops within its row: numbers are missing, or the blank that follows
    each."""
    cells = line.split(",")
    if not _NUMBERS.fullmatch(line) or len(cells) > len(COLUMNS):
        return False
    return len(cells) < len(COLUMNS) or (line.startswith(" ") and not line.endswith(" "))


def read_row(line: str, where: str, problems: list[str], most_rows: int = ROWS) -> Row | None:
    """Read a line of a queue's file. None: each problem was added, as ``where:column: what``."""
    cells = line.split(",")
    if len(cells) != len(COLUMNS):
        wanted = f"a row has {len(COLUMNS)}: {', '.join(COLUMNS)}"
        if len(cells) == 1 and len(re.split(r"[;\s]+", line.strip())) > 1:
            problems.append(f"{where}:1: there are no commas; write commas between the numbers: {wanted}")
            return None
        problems.append(f"{where}:1: {len(cells)} numbers; {wanted}")
        return None
    before = len(problems)
    values = []
    column = 1
    for index, cell in enumerate(cells):
        at = f"{where}:{column + len(cell) - len(cell.lstrip())}"
        values.append(_value(cell.strip(), index, at, problems, most_rows if index == 0 else _LARGEST[index]))
        column += len(cell) + 1
    if len(problems) > before:
        return None
    row = Row(*values)
    if not row.position >= 1:
        problems.append(f"{where}:1: position 0 is not of the queue; positions are 1 to {most_rows}")
    elif row.rpm == 0 or row.cycle_us == 0:
        problems.append(f"{where}:1: RPM and cycle cannot be 0")
    elif row.steps == 0:
        problems.append(f"{where}:1: no steps; a queue holds no continuous motion")
    return row if len(problems) == before else None


def _value(text: str, index: int, where: str, problems: list[str], largest: int) -> int:
    name = COLUMNS[index]
    is_hundredths = index in _HUNDREDTHS
    if not _NUMBER.fullmatch(text) or len(text) > 12 or ("." in text and not is_hundredths):
        problems.append(
            f'{where}: {name} is "{text[:20]}"; write a {"" if is_hundredths else "whole "}number'
        )
        return 0
    whole, _, decimals = text.partition(".")
    if not is_hundredths:
        value = int(whole)
    elif len(decimals.rstrip("0")) > 2 or (int(whole or 0) >= 100 and decimals.strip("0")):
        problems.append(
            f"{where}: {name} is {text}; a board keeps two decimals below 100, and none from there on"
        )
        return 0
    else:
        value = int(whole or 0) * 100 + int((decimals + "00")[:2])
    if value > largest:
        limit = largest // 100 if is_hundredths else largest
        problems.append(f"{where}: {name} is {text}; {limit} is the largest")
    return value


def is_line(text: str) -> bool:
    """True if a board takes the text as a line."""
    return len(text) <= LINE_BYTES and text.isascii() and text.isprintable()


def write_queue(rows: list[Row]) -> bytes:
    """Write a queue's file, as the companion writes it."""
    texts = ([_decimal(n) if i in _HUNDREDTHS else str(n) for i, n in enumerate(row)] for row in rows)
    return "".join(",".join(f" {text} " for text in row) + "\r\n" for row in texts).encode()


def _decimal(hundredths: int) -> str:
    if hundredths == 0:
        return "0"
    text = f"{hundredths // 100}.{hundredths % 100:02}".rstrip("0").rstrip(".")
    return text.removeprefix("0")


def read_one_shot(data: bytes, file: str, number: int) -> str:
    """Read command ``number``, from 1, of a one-shot file.

    Raises:
        Refusal: there is none, or it is no line that a board takes.
    """
    lines, _ = split_lines(data, file)
    if not 1 <= number <= ONE_SHOTS:
        raise Refusal(f"{file}: there is no one-shot {number}; a file has 1 to {ONE_SHOTS}")
    command = lines[number - 1].strip() if number <= len(lines) else ""
    if not command:
        filled = [str(n) for n, line in enumerate(lines, 1) if line.strip()]
        raise Refusal(
            f"{file}:{number}:1: one-shot {number} is empty; filled are {', '.join(filled) or 'none'}"
        )
    if not is_line(command):
        raise Refusal(f"{file}:{number}:1: no command: at most {LINE_BYTES} printable ASCII characters")
    return command


def read_one_shots(data: bytes, file: str) -> list[str]:
    """Read all 100 commands of a one-shot file, "" for an empty slot. Missing lines at the end are such.

    Raises:
        Refusal: a line is none that a board takes, or the file was cut off.
    """
    lines, is_whole = split_lines(data, file)
    if not lines:
        raise Refusal(f"{file}:1:1: the file is empty")
    problems: list[str] = []
    for number, line in enumerate(lines, 1):
        if number > ONE_SHOTS and line.strip():
            problems.append(f"{file}:{number}:1: a command behind the last; a file has {ONE_SHOTS}")
        elif len(line) > LINE_BYTES:
            what = f"{len(line)} characters; a board takes {LINE_BYTES} a line"
            problems.append(f"{file}:{number}:{LINE_BYTES + 1}: {what}")
        elif "\t" in line:
            what = "a TAB; a command has printable characters only"
            problems.append(f"{file}:{number}:{line.index(chr(9)) + 1}: {what}")
    if not problems and not is_whole and len(lines) < ONE_SHOTS:
        where = f"{file}:{len(lines)}:{len(lines[-1]) + 1}"
        problems.append(f"{where}: the file ends in the middle of one-shot {len(lines)}; {_CUT}")
    if problems:
        raise Refusal("\n".join(problems))
    return (lines + [""] * ONE_SHOTS)[:ONE_SHOTS]
