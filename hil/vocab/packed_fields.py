"""Binary layout of an axis's fields: little-endian, each at its own offset."""

from collections.abc import Iterable
from struct import Struct

_STRUCT_CODES = {"f32": "f", "f64": "d", "i32": "i", "i64": "q"}
STRUCTS = {name: Struct(f"<{code}") for name, code in _STRUCT_CODES.items()}
"""Readers of one value, by the field's type."""


def value_at(packed: bytes, type_: str, offset: int) -> float:
    """Read the value of a type at an offset in bytes."""
    value: float = STRUCTS[type_].unpack_from(packed, offset)[0]
    return value


def struct_of(places: Iterable[tuple[str, int]], size: int = 0) -> Struct:
    """Make the reader and writer of several values. ``places``: their types and offsets in bytes, in the
    order of the offsets; ``size``: length of all in bytes, if it is more than to the last one's end."""
    layout, end = "<", 0
    for type_, offset in places:
        layout += f"{offset - end}x{_STRUCT_CODES[type_]}"
        end = offset + STRUCTS[type_].size
    return Struct(f"{layout}{max(size - end, 0)}x")
