"""Pulse trains for a step/dir interface: generated, or read from a file. Pure; times count from the start."""

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from math import isqrt

from hil.vocab.parameters import plain

MAX_RATE_HZ = 200_000
"""Maximum rate of steps: a Mechaduino's interrupts follow no faster one (48 MHz: 240 cycles a step)."""
MAX_STEPS = 100_000_000
"""Maximum number of steps of one run."""
MAX_ROWS = 200_000
"""Maximum rows of one train: they take some 0.2 s of a processor at once."""
MAX_RAMP_STEPS = MAX_ROWS // 2 - 1
"""Maximum steps of a ramp. Each is a row of its own, up and down; the direction and the steps between are two
more."""
MAX_NS = 1 << 60
MAX_FILE_VALUE = 1_000_000_000
_NS_PER_S = 1_000_000_000
LEVEL_COLUMNS = ("step", "dir", "enable", "D3", "MS1", "MS2", "sleep", "reset")


class TrainError(Exception):
    """Error of a train that makes no sense: ``str(error)`` has a line for each problem, ``file:line: what;
    remedy``."""


@dataclass(frozen=True)
class Edges:
    """A single edge: at ``at_ns`` the pin gets the level. With ``steps``: that many pulses on the step input;
    edge j of the 2 * steps (a rise if even) is at ``at_ns`` + floor(j * duration_ns / (2 * steps))."""

    at_ns: int
    pin: str = "step"
    level: int = 0
    steps: int = 0
    duration_ns: int = 0

    @property
    def end_ns(self) -> int:
        """Earliest time of the next row."""
        return self.at_ns + (self.duration_ns if self.steps else 0)


Train = tuple[Edges, ...]


def train_length_ns(train: Sequence[Edges]) -> int:
    """Duration from the start to the end of the last run."""
    return train[-1].end_ns if train else 0


def train_problem(train: Sequence[Edges], inputs: Collection[str] = LEVEL_COLUMNS) -> str | None:
    """Reason why rows from outside are no train, or None. ``inputs``: those that the board has."""
    pins = [pin for pin in LEVEL_COLUMNS if pin in inputs]
    if "step" not in pins:
        return "it has no step input"
    end_ns = 0
    for i, e in enumerate(train, start=1):
        if e.pin not in pins or e.level not in (0, 1) or e.steps < 0:
            return f"row {i}: pins are {', '.join(pins)}; levels are 0 and 1; steps are 0 or more"
        if not end_ns <= e.at_ns <= MAX_NS:
            return f"row {i}: it begins before the row above has ended, or too late"
        if e.steps and (problem := _run_problem(e.steps, e.duration_ns)):
            return f"row {i}: {problem}"
        end_ns = e.end_ns
    return None


def _run_problem(steps: int, duration_ns: int) -> str | None:
    """Reason why a run of so many steps cannot be, or None."""
    if steps > MAX_STEPS:
        return f"{steps} steps; write at most {MAX_STEPS:,} in a row"
    shortest_ns = steps * _NS_PER_S // MAX_RATE_HZ
    if duration_ns < shortest_ns - 1:  # a ramp's single steps are rounded down
        return (
            f"{steps} steps do not fit in {duration_ns} ns; at {MAX_RATE_HZ:,} Hz they take {shortest_ns} ns"
        )
    return f"{duration_ns} ns are too long" if duration_ns > MAX_NS else None


def generate(steps: int, rate_hz: float, acceleration_hz_per_s: float | None = None) -> Train:
    """Generate a move of ``steps`` (negative: towards smaller counts, direction input high) at ``rate_hz``;
    with an acceleration (steps/s per s), up to the rate and down from it as far as the steps reach. A
    Mechaduino takes edges of the direction input, and no level that was there before.

    Raises:
        TrainError: a number is out of range.
    """
    problems = []
    if not 0 < abs(steps) <= MAX_STEPS:
        problems.append(f"{steps} steps: write 1 to {MAX_STEPS:,}, negative for the other direction")
    if not 0 < rate_hz <= MAX_RATE_HZ or 2 * _NS_PER_S / rate_hz * abs(steps) > MAX_NS:
        problems.append(f"a rate of {plain(rate_hz)} Hz: write more than 0, up to {MAX_RATE_HZ:,}")
    if acceleration_hz_per_s is not None and not 1e-3 <= acceleration_hz_per_s <= 1e12:
        problems.append(
            f"an acceleration of {plain(acceleration_hz_per_s)} steps/s2: write 0.001 to 1e12, or none"
        )
    if problems:
        raise TrainError("\n".join(problems))
    direction = Edges(0, pin="dir", level=int(steps < 0))
    count = abs(steps)
    if acceleration_hz_per_s is None:
        return direction, Edges(0, steps=count, duration_ns=round(count * _NS_PER_S / rate_hz))
    ramp = min(int(rate_hz * rate_hz / (2 * acceleration_hz_per_s)), count // 2)
    if ramp > MAX_RAMP_STEPS:
        raise TrainError(
            f"ramps of {ramp:,} steps; write an acceleration that reaches the rate in {MAX_RAMP_STEPS:,}"
        )
    # The k-th step of the ramp ends when k steps are done under constant acceleration: t = sqrt(2 k / a).
    scale = int(2 * _NS_PER_S * _NS_PER_S / acceleration_hz_per_s)
    ends = [isqrt(scale * k) for k in range(ramp + 1)]
    up = [later - earlier for earlier, later in itertools.pairwise(ends)]
    rows, at_ns = [direction], 0
    for duration_ns, n in [
        *((d, 1) for d in up),
        (round((count - 2 * ramp) * _NS_PER_S / rate_hz), count - 2 * ramp),
        *((d, 1) for d in reversed(up)),
    ]:
        if n:
            rows.append(Edges(at_ns, steps=n, duration_ns=duration_ns))
            at_ns += duration_ns
    return tuple(rows)


def parse_train(text: str, name: str) -> Train:
    """Parse a train from CSV text with a header. Either levels, one row for each time at which something
    changes: ``at_s`` and one or more of ``LEVEL_COLUMNS`` (as logic analysers export; the first column
    may have any name that holds "time"); or runs: ``at_s, steps, duration_s``, negative steps for the other
    direction.

    Raises:
        TrainError: with every problem, ``name:line:column`` in front.
    """
    lines = text.splitlines()
    rows = [[cell.strip().strip('"') for cell in line.split(",")] for line in lines]
    if not rows:
        raise TrainError(f"{name}:1:1: the file is empty; write a header, such as at_s,step,dir")
    header = [_column(cell, i) for i, cell in enumerate(rows[0])]
    levels = {pin: -1 for pin in LEVEL_COLUMNS}
    if header == ["at_s", "steps", "duration_s"]:
        read = _run
    elif header[0] == "at_s" and len(header) > 1 and set(header[1:]) <= set(LEVEL_COLUMNS):
        read = _levels
    else:
        if len(header) == 1 and (other := next((each for each in (";", "\t") if each in lines[0]), "")):
            what = "a tab" if other == "\t" else f'"{other}"'
            remedy = "write commas there, and a point before decimals"
            raise TrainError(
                f"{name}:1:{lines[0].index(other) + 1}: columns are separated by {what}; {remedy}"
            )
        raise TrainError(
            f"{name}:1:1: the header is {lines[0].strip()}; write at_s,steps,duration_s, or at_s and some of "
            + ",".join(LEVEL_COLUMNS)
        )
    problems: list[str] = []
    train: list[Edges] = []
    end_ns = 0
    for line, row in enumerate(rows[1:], start=2):
        if not any(row):
            continue
        at = 0
        try:
            if len(row) != len(header):
                raise ValueError(f"{len(row)} columns; write {len(header)}")
            numbers: list[Decimal] = []
            while len(numbers) < len(row):
                at = len(numbers)
                numbers.append(_number(row[at]))
            at = 0
            edges = read(dict(zip(header, numbers, strict=True)), levels)
            if edges and edges[0].at_ns < end_ns:
                end = f"{Decimal(end_ns) / _NS_PER_S:f}"
                remedy = f"write {end} or more, or sort the rows"
                raise ValueError(f"begins before the row above has ended, at {end} s; {remedy}")
        except ValueError as error:
            problems.append(f"{name}:{line}:{_begin(lines[line - 1], at)}: {error}")
            continue
        train += edges
        end_ns = max([end_ns, *(e.end_ns for e in edges)])
    if problems:
        raise TrainError("\n".join(problems))
    return tuple(train)


def _begin(line: str, at: int) -> int:
    """Column of a cell in its line, from 1 on."""
    cells = line.split(",")
    return sum(len(each) + 1 for each in cells[:at]) + len(cells[at]) - len(cells[at].lstrip()) + 1


def _column(cell: str, index: int) -> str:
    if index == 0 and "time" in cell.lower():
        return "at_s"
    return next((column for column in LEVEL_COLUMNS if column.lower() == cell.lower()), cell)


def _number(cell: str) -> Decimal:
    try:
        number = Decimal(cell)
    except InvalidOperation:
        raise ValueError(f"{cell!r} is not a number; write one, as 0.001") from None
    if not number.is_finite() or abs(number) > MAX_FILE_VALUE:
        raise ValueError(f"{cell} is out of range; write at most {MAX_FILE_VALUE:,}")
    return number


def _ns(seconds: Decimal) -> int:
    if seconds < 0:
        raise ValueError(f"{seconds} s is before the start; write 0 or more")
    return round(seconds * _NS_PER_S)


def _run(row: dict[str, Decimal], levels: dict[str, int]) -> list[Edges]:
    at_ns, duration_ns, steps = _ns(row["at_s"]), _ns(row["duration_s"]), int(row["steps"])
    if steps != row["steps"] or steps == 0:
        raise ValueError(f"{row['steps']} steps; write a whole number other than 0")
    if problem := _run_problem(abs(steps), duration_ns):
        raise ValueError(problem)
    turned = levels["dir"] != int(steps < 0)
    levels["dir"] = int(steps < 0)
    direction = [Edges(at_ns, pin="dir", level=levels["dir"])] if turned else []
    return [*direction, Edges(at_ns, steps=abs(steps), duration_ns=duration_ns)]


def _levels(row: dict[str, Decimal], levels: dict[str, int]) -> list[Edges]:
    at_ns = _ns(row["at_s"])
    edges = []
    for pin in reversed(LEVEL_COLUMNS):  # the direction before the step that it is for
        if pin not in row:
            continue
        if row[pin] not in (0, 1):
            raise ValueError(f"{pin} is {row[pin]}; write 0 or 1")
        if levels[pin] != row[pin]:
            levels[pin] = int(row[pin])
            edges.append(Edges(at_ns, pin=pin, level=levels[pin]))
    return edges
