"""Fields of a board's own: a relay, a temperature, a counter. Its firmware writes and reads them, and who
looks at the board finds them beside, or instead of, the fields of an axis."""

from collections.abc import Iterator, Mapping, MutableMapping
from dataclasses import field
from typing import Protocol

from hil.vocab.late_dataclass import dataclass
from hil.vocab.parameters import plain

MOST_FIELDS = 32
"""Maximum number of a board's own fields."""
WHOLE = range(-(1 << 31), 1 << 31)
"""Whole numbers that have 32 bits on a bus; fields with others have 64."""
MOST = float(1 << 53)
"""Bound of every field: whole numbers up to it are exact."""


@dataclass(frozen=True)
class OwnField:
    """Field of a board's own. ``type``: as in the binary layout, f64, i32 or i64; ``low``, ``high``: its
    range, in its unit; ``start``: its value at power-up; ``is_input``: it is the world around the board, set
    from outside, and stays through a reset."""

    name: str
    type: str = "f64"
    unit: str = ""
    about: str = ""
    low: float = -MOST
    high: float = MOST
    start: float = 0.0
    is_input: bool = False

    @property
    def is_whole(self) -> bool:
        """True if it has whole numbers alone."""
        return self.type != "f64"

    def refusal(self, value: float) -> str | None:
        """Reason why it cannot have a value, or None."""
        if value < self.low:
            return f"{plain(value)} is below {plain(self.low)}"
        if not value <= self.high:  # not a number is above all
            return f"{plain(value)} is above {plain(self.high)}"
        return f"{value:g} is no whole number" if self.is_whole and value != int(value) else None


@dataclass(frozen=True)
class FieldFaults:
    """Faults in force on a board's own fields, by their names. ``stuck``: values that the firmware reads;
    ``offsets``: what is added to those that it reads."""

    stuck: Mapping[str, float] = field(default_factory=dict)
    offsets: Mapping[str, float] = field(default_factory=dict)


NO_FAULTS = FieldFaults()


class FieldCells(Protocol):
    """Axis that has a board's own fields, by name."""

    field_faults: FieldFaults

    def get(self, field: str) -> float: ...

    def set(self, field: str, value: float) -> None: ...


class OwnFields(MutableMapping[str, float]):
    """Fields of a board's own as its firmware has them, by name: reading one answers its value now, whole
    numbers as ``int``. A value out of its range is a ValueError, another name a KeyError."""

    def __init__(self, fields: dict[str, OwnField], cells: FieldCells | None) -> None:
        self._fields, self._cells = fields, cells

    def __getitem__(self, name: str) -> float:
        own = self._known(name)
        assert self._cells is not None
        faults, value = self._cells.field_faults, self._cells.get(name)
        if faults is not NO_FAULTS:
            value = faults.stuck.get(name, value) + faults.offsets.get(name, 0.0)
            value = min(max(value, own.low), own.high)
        return int(value) if own.is_whole else value

    def __setitem__(self, name: str, value: float) -> None:
        own = self._known(name)
        if not isinstance(value, int | float):
            raise TypeError(f"field {name}: write a number, not {type(value).__name__}")
        if problem := own.refusal(value):
            raise ValueError(f"field {name}: {problem}")
        assert self._cells is not None
        if own.is_input or name not in self._cells.field_faults.stuck:
            self._cells.set(name, float(value))

    def __delitem__(self, name: str) -> None:
        raise TypeError("a board's fields stay: they are its profile's")

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def _known(self, name: str) -> OwnField:
        if name not in self._fields:
            raise KeyError(f"the board has no field {name!r}; it has {', '.join(self._fields) or 'none'}")
        return self._fields[name]

    def power_up(self) -> None:
        """Give fields of the firmware's own the values of a power-up; inputs stay as they are."""
        for name, own in self._fields.items():
            if not own.is_input:
                self[name] = own.start
