"""The fields of an axis, by name, from the native core's one table (``native/fields.def``)."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hil.core import _native
from hil.core.abi import Kind
from hil.vocab.late_dataclass import dataclass
from hil.vocab.packed_fields import STRUCTS, struct_of


@dataclass(frozen=True)
class Field:
    """Field of an axis. ``type`` is f32, f64, i32 or i64."""

    name: str
    type: str
    unit: str
    writable: bool
    meaning: str
    kind: int = Kind.any
    """Kinds of axis that have it, as bits of ``hil.core.abi.Kind``."""


FIELDS: dict[str, Field] = {row[0]: Field(*row) for row in _native.FIELDS}
INDEX: dict[str, int] = {name: index for index, name in enumerate(FIELDS)}
TABLE = tuple(FIELDS.values())
"""Fields by their indices."""


def described(name: str) -> Field:
    """Describe a field by its name alone. One that is not in the table is a board's own, as the voltage at a
    pin with a name of its own (``AxisKind.own_fields``): it has the unit that its name ends in."""
    ending = name.rpartition("_")[2]
    unit = ending if ending != name and ending in _UNITS else ""
    return FIELDS.get(name) or Field(name, "f64", unit, False, "voltage at a pin" if unit == "V" else name)


_MORE_UNITS = (
    *("mA", "mV", "W", "kW", "Wh", "kWh", "VA", "ohm", "K", "degF", "Pa", "hPa", "kPa", "bar", "mbar"),
    *("m", "mm", "um", "g", "kg", "N", "s", "ms", "min", "h", "kHz", "rad", "l", "ml", "pct", "ppm", "lx"),
)
_UNITS = {field.unit for field in FIELDS.values()}.union(_MORE_UNITS)
"""Units in which names of a board's own fields end."""


def fields_of(kind: Kind, has_motor: bool = True) -> dict[str, int]:
    """Indices in the table, by name, of the fields that a kind of axis has. One without a motor has the time
    and its own."""
    shared = [name for name, field in FIELDS.items() if field.kind == Kind.any] if has_motor else ["at_ns"]
    return {name: INDEX[name] for name, field in FIELDS.items() if name in shared or field.kind & kind}


class Snapshot:
    """State of an axis at one simulated time: an attribute for each field that its kind of axis has.

    ``values``: of all fields of the table, those that its kind has not too; ``names``: indices of those that
    it has."""

    __slots__ = ("names", "values")

    def __init__(self, values: Sequence[float], names: Mapping[str, int]) -> None:
        self.values = values
        self.names = names

    def __getattr__(self, name: str) -> Any:
        try:
            return self.values[self.names[name]]
        except KeyError:
            raise AttributeError(f"a snapshot has no {name!r}; it has {', '.join(self.names)}") from None

    def as_dict(self) -> dict[str, float]:
        """Every field by its name, in the table's order."""
        return {name: self.values[index] for name, index in self.names.items()}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Snapshot) and repr(self.values) == repr(other.values)

    def __hash__(self) -> int:
        return hash(repr(self.values))

    def __repr__(self) -> str:
        """Format for who reads it: the fields that say most, rounded; ``as_dict`` has them all."""
        most = [name for name in _SHOWN if name in self.names] or [*self.names][1:]
        shown = [f"{name}={_shown(name, getattr(self, name))}" for name in most]
        return f"Snapshot({', '.join([f'at {self.at_ns / 1e9:g} s', *shown])})"


_SHOWN = (
    *("position_deg", "velocity_rpm", "yw", "r", "u", "mode", "loop_on", "commanded_deg", "speed_rpm"),
    *("lost_steps", "to_be_deg", "measured_deg", "is_enabled", "load_torque_Nm"),
)
"""Fields that say most of an axis: where it is, where it should be, and what drives it."""


def _shown(name: str, value: float) -> str:
    return repr(chr(int(value))) if name == "mode" and value else f"{round(value, 4):g}"


def _layout() -> tuple[dict[str, int], int]:
    """Offsets and total length: fields in their order, each at a multiple of its own size."""
    offsets, end = {}, 0
    for field in FIELDS.values():
        size = STRUCTS[field.type].size
        offsets[field.name] = -(-end // size) * size
        end = offsets[field.name] + size
    return offsets, -(-end // 8) * 8


OFFSETS, PACKED_BYTES = _layout()
"""Binary layout of a snapshot, as ``take_samples`` gives it."""


_PACKED = struct_of(((field.type, OFFSETS[field.name]) for field in FIELDS.values()), PACKED_BYTES)


def packed(values: Sequence[float]) -> bytes:
    """Pack values of all fields in the binary layout."""
    return _PACKED.pack(*values)


def reader(name: str) -> Callable[[bytes], float]:
    """Make a function that reads one field of a packed snapshot."""
    unpack, offset = STRUCTS[FIELDS[name].type].unpack_from, OFFSETS[name]
    return lambda packed: unpack(packed, offset)[0]
