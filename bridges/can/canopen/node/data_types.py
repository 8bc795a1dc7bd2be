"""Values of entries as bytes, little-endian, and which values clients may write.

Source: CiA 301 version 4.2.0, 7.1; 7.3.5 (restricted CAN-IDs) and 7.5.2.
"""

from collections.abc import Mapping
from struct import Struct, error
from typing import NamedTuple

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.can_ids import ID_MASK, INVALID, NO_RTR
from bridges.can.canopen.node.application import DataType, Entry, SdoAbort, Value

STRUCTS = {
    DataType.BOOLEAN: Struct("<B"),
    DataType.INTEGER8: Struct("<b"),
    DataType.INTEGER16: Struct("<h"),
    DataType.INTEGER32: Struct("<i"),
    DataType.INTEGER64: Struct("<q"),
    DataType.UNSIGNED8: Struct("<B"),
    DataType.UNSIGNED16: Struct("<H"),
    DataType.UNSIGNED32: Struct("<I"),
    DataType.UNSIGNED64: Struct("<Q"),
    DataType.REAL32: Struct("<f"),
    DataType.REAL64: Struct("<d"),
}
"""Layouts of the types that have the length of a number in a processor."""


class OddInteger(NamedTuple):
    """Layout of an integer of a length that no ``Struct`` has, used as one."""

    size: int
    is_signed: bool

    def pack(self, value: int | float) -> bytes:
        """Encode a whole number. Raises OverflowError: it has more bytes."""
        return int(value).to_bytes(self.size, "little", signed=self.is_signed)

    def unpack(self, data: bytes) -> tuple[int]:
        return (int.from_bytes(data, "little", signed=self.is_signed),)


_ODD = {
    DataType.INTEGER24: OddInteger(3, True),
    DataType.INTEGER40: OddInteger(5, True),
    DataType.INTEGER48: OddInteger(6, True),
    DataType.INTEGER56: OddInteger(7, True),
    DataType.UNSIGNED24: OddInteger(3, False),
    DataType.UNSIGNED40: OddInteger(5, False),
    DataType.UNSIGNED48: OddInteger(6, False),
    DataType.UNSIGNED56: OddInteger(7, False),
}
_LAYOUTS: Mapping[DataType, Struct | OddInteger] = {**STRUCTS, **_ODD}
"""Layouts of all types that have a fixed length; the others are bytes as they come."""
REALS = (DataType.REAL32, DataType.REAL64)
_SIGNED = frozenset(each for each in _LAYOUTS if each.name.startswith("INTEGER"))
LONGEST = 65536
"""Bytes of a value without a limit of its own. Decision: as much as a device would set aside."""


def size_of(data_type: DataType) -> int:
    """Number of bytes of a type; 0 if its values differ in length."""
    layout = _LAYOUTS.get(data_type)
    return layout.size if layout else 0


def bounds_of(data_type: DataType) -> tuple[int, int]:
    """Least and greatest number of a type of integers; (0, 0) of all others."""
    return _BOUNDS[data_type]


def _bounds(data_type: DataType) -> tuple[int, int]:
    if data_type in REALS or not (size := size_of(data_type)):
        return 0, 0
    if data_type is DataType.BOOLEAN:
        return 0, 1
    bits = 8 * size
    return (-(1 << bits - 1), (1 << bits - 1) - 1) if data_type in _SIGNED else (0, (1 << bits) - 1)


_BOUNDS = {each: _bounds(each) for each in DataType}


def of_sign(data_type: DataType, value: int) -> int:
    """Number with the same bits that a type of integers can have, if there is one; else unchanged."""
    low, high = bounds_of(data_type)
    span = high - low + 1
    if high < value <= high - low:
        return value - span
    return value + span if low == 0 and -(span >> 1) <= value < 0 else value


def real_of_bits(data_type: DataType, bits: int) -> float:
    """Real number that these bits are. Raises OverflowError: there are more than the type has."""
    layout = STRUCTS[data_type]
    value: float = layout.unpack(bits.to_bytes(layout.size, "little"))[0]
    return value


def longest(entry: Entry) -> int:
    """Highest number of bytes that an entry takes."""
    return size_of(entry.data_type) or int(LONGEST if entry.high is None else entry.high)


def pack(data_type: DataType, value: Value) -> bytes:
    """Encode a value. Raises ValueError: it is none of this type."""
    layout = _LAYOUTS.get(data_type)
    if layout is None:
        if isinstance(value, bytes):
            return value
    elif not isinstance(value, bytes):
        try:
            return layout.pack(value)
        except (error, OverflowError):
            pass
    raise ValueError(f"{value!r} is no {data_type.name}")


def unpack(data_type: DataType, data: bytes) -> Value:
    """Decode a value of the right length."""
    layout = _LAYOUTS.get(data_type)
    if layout is None:
        return data
    value: int | float = layout.unpack(data)[0]
    return value


def check_length(entry: Entry, length: int) -> None:
    """Check the number of bytes that are to be written. Raises SdoAbort."""
    if length > longest(entry):
        raise SdoAbort(AbortCode.TOO_LONG)
    if length < size_of(entry.data_type):
        raise SdoAbort(AbortCode.TOO_SHORT)


def check_limits(entry: Entry, value: Value) -> None:
    """Check a value that is to be written. Raises SdoAbort."""
    if isinstance(value, bytes):
        return
    if entry.data_type is DataType.BOOLEAN and value > 1:
        raise SdoAbort(AbortCode.TOO_HIGH)
    if entry.high is not None and value > entry.high:
        raise SdoAbort(AbortCode.TOO_HIGH)
    if entry.low is not None and value < entry.low:
        raise SdoAbort(AbortCode.TOO_LOW)
    if value != value:  # not a number
        raise SdoAbort(AbortCode.VALUE)


_RESTRICTED = (
    range(0x000, 0x080),
    range(0x101, 0x181),
    range(0x581, 0x600),
    range(0x601, 0x680),
    range(0x6E0, 0x800),
)


def check_cob_id(former: int, cob_id: int) -> None:
    """Check a COB-ID whose bit 31 means that the service does not exist. It has to be of a base frame and not
    restricted, and it cannot change while the service exists. Raises SdoAbort."""
    if cob_id & INVALID:
        return
    check_id(cob_id & ~NO_RTR)
    if not former & INVALID and (former ^ cob_id) & ID_MASK:
        raise SdoAbort(AbortCode.NOT_NOW, "the COB-ID is in use: set bit 31 first")


def check_id(can_id: int) -> None:
    """Check an identifier that a client chooses. Raises SdoAbort."""
    if can_id > 0x7FF or any(can_id in each for each in _RESTRICTED):
        raise SdoAbort(AbortCode.VALUE, "the CAN-ID is restricted or has more than 11 bits")
