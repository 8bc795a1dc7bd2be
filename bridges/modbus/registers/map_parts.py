"""Parts of a map of version 2 beside values and bits: cells, commands by value, states, blocks, moves, and
the drive's manners on the line.

What they mean to a unit is in ``bridges.modbus.registers.map_unit``; how they are written in
``bridges.modbus.maps``.
"""

from collections.abc import Callable, Mapping
from dataclasses import field, replace
from math import inf, isfinite

from bridges.modbus.protocol.pdu import Code, Table
from hil.vocab.late_dataclass import dataclass

Factor = float | str
"""Number, or the name of the cell that has it."""
Look = Callable[[str], float]
"""Answers the value of a cell in effect, by its name."""

COMMANDS_BY_WORD = {
    "nothing": "do nothing",
    "enable": "switch the loop on",
    "disable": "take the current off",
    "start": "move to the set-point, or turn, as the mode says",
    "start_absolute": "move to the set-point",
    "start_relative": "move by the set-point",
    "start_directed": "move by the set-point, forward or in reverse as the last command of a direction says",
    "run": "turn at `set_velocity_rpm`, whose sign and `reverse` say the direction, until a stop",
    "forward": "turn in the direction of the speed's sign, from now on",
    "reverse": "turn in the other direction, from now on",
    "turn_about": "turn in the other direction than now",
    "stop": "stop by the ramp",
    "halt": "stop at once",
    "reset": "clear the fault",
    "home": "move to 0",
    "search_home": "search home by `homing_method`, and let it be 0",
    "zero": "let the shaft's angle be 0",
    "store": "store the cells that are `stored: by_command`",
    "restore": "give all cells their defaults, and store them",
}
"""Words of commands, with their meanings; ``move_0``, ``move_1`` and so on start a row of ``moves``."""
CONDITIONS = {
    "enabled": "the loop is on",
    "disabled": "the loop is off",
    "moving": "the set-point moves",
    "standing": "it does not",
    "running": "it turns by `run`",
    "arrived": "the loop is on, and the set-point stands",
    "at_speed": "the set-point moves at the speed that was set",
    "backward": "the shaft turns, or would, in the direction of falling angles",
    "reversed": "`reverse` was the last command of a direction",
    "fault": "the drive has a fault, or its firmware has stopped",
    "sound": "it has none",
    "ready": "it has none, and the loop is off",
    "home_switch": "the input D3 is low: the home switch is active",
    "negative_limit": "the input D0 is high: the limit switch at the lower end is active",
    "positive_limit": "the input D1 is high: that at the upper end is",
    "homing": "it searches home",
    "homed": "the last search has found it, or the last `home` has arrived, since power-up",
    "home_missed": "the last search has not, and has ended",
    "stored": "the cells that are `stored: by_command` are stored as they are",
}
"""Conditions of states and refusals, with their meanings."""
MODES = ("absolute", "relative", "velocity", "home", "search_home")
"""Meanings of the numbers of a mode."""
CIA402 = "cia402"
"""Standard of control and status words."""
CAUSES = {
    "function": (Code.ILLEGAL_FUNCTION, "a function that it has not"),
    "address": (Code.ILLEGAL_DATA_ADDRESS, "a register that it has not"),
    "read_only": (Code.ILLEGAL_DATA_ADDRESS, "a write of what can only be read"),
    "write_only": (Code.ILLEGAL_DATA_ADDRESS, "a read of what can only be written"),
    "half": (Code.ILLEGAL_DATA_ADDRESS, "a part of a value, with `halves: refuse`"),
    "count": (Code.ILLEGAL_DATA_VALUE, "more registers than one request may have, or a part of a block"),
    "value": (Code.ILLEGAL_DATA_VALUE, "a value or a command that it does not know"),
    "locked": (Code.ILLEGAL_DATA_ADDRESS, "a cell that is locked"),
    "busy": (Code.SERVER_DEVICE_BUSY, "what is not possible now"),
}
"""Causes of exceptions: the code unless a map has another, and the meaning."""


@dataclass(frozen=True)
class Conversion:
    """Conversion of a register's number to a value beside its scale. With n = number x ``scale`` x ``times``
    / ``per`` / 10^``decimals`` + ``offset``, the value is n x ``factor``, or ``time_to`` / (n x ``factor``)
    of a ramp that is written as a time. Names are cells, until ``resolved``."""

    times: Factor = 1.0
    per: Factor = 1.0
    decimals: Factor = 0.0
    offset: float = 0.0
    factor: float = 1.0
    time_to: Factor | None = None
    at_zero: float | None = None
    """Value of the number 0, for which the formula does not hold."""
    shown: str = ""
    """Unit of the number, for people."""

    def resolved(self, look: Look) -> "Conversion":
        """Conversion with the numbers of now in place of names."""

        def number(of: Factor) -> float:
            return look(of) if isinstance(of, str) else of

        time_to = None if self.time_to is None else number(self.time_to)
        per = number(self.per) or 1.0
        return replace(
            self, times=number(self.times), per=per, decimals=number(self.decimals), time_to=time_to
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the cells that it looks at."""
        given = (self.times, self.per, self.decimals, self.time_to)
        return tuple(each for each in given if isinstance(each, str))

    @property
    def _step(self) -> float:
        times, per, decimals = float(self.times), float(self.per), float(self.decimals)
        return times / per / (10.0**decimals if abs(decimals) <= 12 else 1.0)

    def value(self, scaled: float) -> float:
        """Value of a number that has its scale."""
        if self.at_zero is not None and not scaled:
            return self.at_zero
        converted = (scaled * self._step + self.offset) * self.factor
        if self.time_to is None:
            return converted + 0.0
        return float(self.time_to) / converted if converted > 0 else inf

    def scaled(self, value: float) -> float:
        """Number of a value, before its scale."""
        if value == self.at_zero:
            return 0.0
        if self.time_to is not None:
            value = float(self.time_to) / value if value and isfinite(value) else (0.0 if value else inf)
        return (value / self.factor - self.offset) / (self._step or 1.0)


@dataclass(frozen=True)
class WriteGuard:
    """Conditions of a write. ``locked_by``: name of the cell that must have ``unlocked`` meanwhile;
    ``refused``: exceptions by the conditions under which a write is refused; ``locked``: that of the lock."""

    locked_by: str | None = None
    unlocked: float = 0.0
    locked: int | None = None
    refused: Mapping[str, int] = field(default_factory=dict)


FREE = WriteGuard()


@dataclass(frozen=True)
class CellPart:
    """Plain cell. ``default``: its value at first, or for good if it can only be read; ``lowest``,
    ``highest``: limits of what is written; ``is_read``: a master may read it; ``is_written``: and write it;
    ``keeps``: when what was written is stored, ``at_once``, ``by_command`` or ``never``;
    ``waits``: it is in effect from the next store on; ``unit``, ``about``: for people."""

    default: float = 0.0
    lowest: float = -inf
    highest: float = inf
    is_read: bool = True
    is_written: bool = True
    keeps: str = "never"
    waits: bool = False
    unit: str = ""
    about: str = ""
    guard: WriteGuard = FREE


@dataclass(frozen=True)
class CommandPart:
    """Commands by value. ``words``: those of each number; ``is_kept``: the number is read back, else 0;
    ``ignores_others``: a number without words does nothing, else it is refused; ``standard``: of a control
    word, in place of words; ``sets_mode``: meanings of a mode's numbers, in place of words."""

    words: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    is_kept: bool = False
    ignores_others: bool = False
    standard: str = ""
    sets_mode: Mapping[int, str] = field(default_factory=dict)
    default: int = 0
    guard: WriteGuard = FREE
    about: str = ""


@dataclass(frozen=True)
class StatePart:
    """Word that tells states: the number of the first condition that holds, else ``otherwise``."""

    numbers: tuple[tuple[str, int], ...] = ()
    otherwise: int = 0
    standard: str = ""
    about: str = ""


@dataclass(frozen=True)
class BlockPart:
    """Block that is read or written as a whole, from its first address on: others may overlap it.
    ``number``: from 1 on; ``words``: commands that a write of it is; ``at_zero_speed``: those in their place
    where the speed that is written is 0."""

    number: int
    table: Table
    address: int
    registers: int
    words: tuple[str, ...] = ()
    at_zero_speed: tuple[str, ...] = ()

    @property
    def base(self) -> int:
        """Address of its first register among those of blocks, which no table has."""
        return self.number << 16


@dataclass(frozen=True)
class MovesPart:
    """Table of moves: rows of cells, ``move_N.NAME``. ``names``: those that a row has; ``modes``: meanings of
    the numbers of its mode."""

    count: int = 0
    names: frozenset[str] = frozenset()
    modes: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Manners:
    """Manners of a drive on the line. ``functions``: those that it has, None: all; ``reads_most``,
    ``writes_most``: registers of one request; ``pause_ns``: silence behind an answer, in which it hears
    nothing; ``reads_gaps``: registers that are nobody's read as 0, and writes to them do nothing;
    ``is_whole``: a part of a value is refused; ``codes``: exceptions of its own, by their cause."""

    functions: frozenset[int] | None = None
    reads_most: int = 125
    writes_most: int = 123
    pause_ns: int = 0
    reads_gaps: bool = False
    is_whole: bool = False
    codes: Mapping[str, int] = field(default_factory=dict)

    def code(self, cause: str) -> int:
        """Exception for a cause, one of ``CAUSES``."""
        return self.codes.get(cause, CAUSES[cause][0])


USUAL, NO_MOVES = Manners(), MovesPart()
