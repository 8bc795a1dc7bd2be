"""Names and types of CANopen objects, and their values in words.

Source: CiA 301, 7.5 (objects 1000h to 1FFFh) and 7.4.7.1 (types); CiA 402-2 (6000h to 67FFh).
"""

from collections.abc import Mapping
from struct import Struct
from typing import NamedTuple

INTEGERS = {f"{sign}{8 * size}": size for sign in "iux" for size in range(1, 9)}
"""Bytes of each type of integers: signed, unsigned, and unsigned as hexadecimal digits."""
_REALS = {"f32": Struct("<f"), "f64": Struct("<d")}
TYPES_BY_NUMBER = {
    **{0x01: "u8", 0x02: "i8", 0x03: "i16", 0x04: "i32", 0x05: "u8", 0x06: "u16", 0x07: "u32"},
    **{0x08: "f32", 0x09: "text", 0x0B: "wide text", 0x11: "f64"},
    **{0x10: "i24", 0x12: "i40", 0x13: "i48", 0x14: "i56", 0x15: "i64"},
    **{0x16: "u24", 0x18: "u40", 0x19: "u48", 0x1A: "u56", 0x1B: "u64"},
}
"""Types by their numbers in an EDS; others are bytes."""
_ALL = """
1000 x32 Device type|1001 x8 Error register|1002 x32 Manufacturer status register
1003 x32 Pre-defined error field|1003.0 u8 Number of errors|1005 x32 COB-ID SYNC
1006 u32 Communication cycle period (us)|1007 u32 Synchronous window length (us)
1008 text Manufacturer device name|1009 text Manufacturer hardware version
100A text Manufacturer software version|100C u16 Guard time (ms)|100D u8 Life time factor
1010 x32 Store parameters|1010.0 u8 Highest sub-index|1011 x32 Restore default parameters
1011.0 u8 Highest sub-index|1012 x32 COB-ID TIME|1014 x32 COB-ID EMCY|1015 u16 Inhibit time EMCY (100 us)
1016 x32 Consumer heartbeat time|1016.0 u8 Highest sub-index|1017 u16 Producer heartbeat time (ms)
1018 u8 Identity|1018.1 x32 Vendor-ID|1018.2 x32 Product code|1018.3 x32 Revision number
1018.4 x32 Serial number|1019 u8 Synchronous counter overflow value|1029 u8 Error behaviour
1F80 x32 NMT startup|6007 i16 Abort connection option code|603F x16 Error code|6040 x16 Controlword
6041 x16 Statusword|605A i16 Quick stop option code|605B i16 Shutdown option code
605C i16 Disable operation option code|605D i16 Halt option code|605E i16 Fault reaction option code
6060 i8 Modes of operation|6061 i8 Modes of operation display|6062 i32 Position demand value
6063 i32 Position actual internal value|6064 i32 Position actual value|6065 u32 Following error window
6066 u16 Following error time out (ms)|6067 u32 Position window|6068 u16 Position window time (ms)
6069 i32 Velocity sensor actual value|606A i16 Sensor selection code|606B i32 Velocity demand value
606C i32 Velocity actual value|606D u16 Velocity window|606E u16 Velocity window time (ms)
606F u16 Velocity threshold|6070 u16 Velocity threshold time (ms)|6071 i16 Target torque
6072 u16 Max torque|6073 u16 Max current|6074 i16 Torque demand|6075 u32 Motor rated current (mA)
6076 u32 Motor rated torque (mNm)|6077 i16 Torque actual value|6078 i16 Current actual value
6079 u32 DC link circuit voltage (mV)|607A i32 Target position|607B u8 Position range limit
607B.1 i32 Minimum|607B.2 i32 Maximum|607C i32 Home offset|607D u8 Software position limit
607D.1 i32 Minimum|607D.2 i32 Maximum|607E x8 Polarity|607F u32 Max profile velocity
6080 u32 Max motor speed|6081 u32 Profile velocity|6082 u32 End velocity|6083 u32 Profile acceleration
6084 u32 Profile deceleration|6085 u32 Quick stop deceleration|6086 i16 Motion profile type
6087 u32 Torque slope|6088 i16 Torque profile type|608F u8 Position encoder resolution
608F.1 u32 Encoder increments|608F.2 u32 Motor revolutions|6090 u8 Velocity encoder resolution
6091 u8 Gear ratio|6091.1 u32 Motor shaft revolutions|6091.2 u32 Driving shaft revolutions
6092 u8 Feed constant|6092.1 u32 Feed|6092.2 u32 Shaft revolutions|6096 u8 Velocity factor
6096.1 u32 Numerator|6096.2 u32 Divisor|6097 u8 Acceleration factor|6097.1 u32 Numerator
6097.2 u32 Divisor|6098 i8 Homing method|6099 u8 Homing speeds|6099.1 u32 Speed during search for switch
6099.2 u32 Speed during search for zero|609A u32 Homing acceleration|60B0 i32 Position offset
60B1 i32 Velocity offset|60B2 i16 Torque offset|60C1 i32 Interpolation data record
60C1.0 u8 Highest sub-index|60C2 u8 Interpolation time period|60C2.1 u8 Interpolation time units
60C2.2 i8 Interpolation time index|60C5 u32 Max acceleration|60C6 u32 Max deceleration
60E0 u16 Positive torque limit|60E1 u16 Negative torque limit|60E3 i8 Supported homing methods
60E3.0 u8 Highest sub-index|60E4 i32 Additional position actual value|60F2 x16 Positioning option code
60F4 i32 Following error actual value|60FA i32 Control effort|60FC i32 Position demand internal value
60FD x32 Digital inputs|60FE u8 Digital outputs|60FE.1 x32 Physical outputs|60FE.2 x32 Bit mask
60FF i32 Target velocity|6402 u16 Motor type|6502 x32 Supported drive modes|67FF x32 Single device type
"""
_PDO_COMMUNICATION = {
    0: "u8 Highest sub-index",
    1: "x32 COB-ID",
    2: "u8 Transmission type",
    3: "u16 Inhibit time (100 us)",
    5: "u16 Event timer (ms)",
    6: "u8 SYNC start value",
}


class ObjectName(NamedTuple):
    """Name and type of an object, or of one of its sub-indices."""

    type: str
    name: str


Names = Mapping[tuple[int, int], ObjectName]
"""Names by index and sub-index; a sub-index without one has its object's, at sub-index 0."""


def _row(text: str) -> tuple[tuple[int, int], ObjectName]:
    where, kind, name = text.split(" ", 2)
    index, _, subindex = where.partition(".")
    # The object itself stands under -1 where its sub-index 0 has a row of its own.
    return (int(index, 16), int(subindex) if subindex else -1), ObjectName(kind, name)


_KNOWN = dict(_row(text) for line in _ALL.strip().splitlines() for text in line.split("|"))
_RECORDS = {index for index, subindex in _KNOWN if subindex > 0}
"""Objects whose sub-indices have names; their own type is that of the number of these."""


class ObjectWords:
    """Names of objects of a node, and values of theirs in words. ``names``: those of its EDS, which come
    first."""

    def __init__(self, names: Names | None = None) -> None:
        self._names = names or {}

    def name(self, index: int, subindex: int) -> str:
        """Name an object with its numbers, as in ``1018h:1 Identity, Vendor-ID``."""
        known, own = self._find(index, -1), self._find(index, subindex)
        has_parts = bool(subindex) or index in _RECORDS or (own is not None and own != known)
        at = f"{index:04X}h:{subindex}" if has_parts else f"{index:04X}h"
        return " ".join((at, ", ".join(each.name for each in dict.fromkeys((known, own)) if each))).rstrip()

    def short(self, index: int, subindex: int) -> str:
        """Name an object by its name alone, or by its numbers."""
        own = self._find(index, subindex) or (self._find(index, -1) if not subindex else None)
        return own.name if own else f"{index:04X}h:{subindex}"

    def value(self, index: int, subindex: int, data: bytes) -> str:
        """Say a value."""
        own = self._find(index, subindex) or self._find(index, -1)
        return value_words(own.type if own else "", data)

    def _find(self, index: int, subindex: int) -> ObjectName | None:
        key = index, subindex
        known = _KNOWN.get(key) or _of_pdo(index, subindex)
        named = self._names.get(key)
        if named and known and known.type.startswith("x") and named.type == known.type.replace("x", "u"):
            return ObjectName(known.type, named.name)  # bits and identifiers say more as digits
        return named or known


def _of_pdo(index: int, subindex: int) -> ObjectName | None:
    """Names of the objects that describe PDOs, of which there are many."""
    for first, kind in ((0x1400, "RPDO"), (0x1800, "TPDO")):
        number = index - first + 1
        if 1 <= number <= 512:
            row = _PDO_COMMUNICATION.get(subindex)
            type_, _, name = (row or "u8 ").partition(" ")
            return ObjectName(type_, f"{kind}{number} communication" if subindex < 0 else name or "?")
        if 1 <= number - 0x200 <= 512:
            number -= 0x200
            if subindex < 0:
                return ObjectName("x32", f"{kind}{number} mapping")
            return ObjectName("x32", f"mapped {subindex}") if subindex else ObjectName("u8", "number mapped")
    return None


def value_words(kind: str, data: bytes) -> str:
    """Say the value that bytes are by a type; what they look like, where it is not known or does not fit."""
    size = INTEGERS.get(kind)
    if size == len(data):
        value = number(kind, data)
        return f"{value:0{2 * size}X}h" if kind[0] == "x" else str(value)
    if (real := _REALS.get(kind)) and real.size == len(data):
        return f"{real.unpack(data)[0]:.{7 if kind == 'f32' else 15}g}"
    if kind == "wide text":
        return repr(data.decode("utf-16-le", "replace").rstrip("\0"))
    if kind == "text" or (len(data) > 4 and _is_text(data)):
        return repr(data.rstrip(b"\0").decode("latin-1"))
    if len(data) in (1, 2, 4):
        value = int.from_bytes(data, "little")
        return f"{value} ({value:0{2 * len(data)}X}h)"
    return data.hex(" ") or "nothing"


def number(kind: str, data: bytes) -> int:
    """Integer that bytes are by a type."""
    return int.from_bytes(data, "little", signed=kind[0] == "i")


def _is_text(data: bytes) -> bool:
    text = data.rstrip(b"\0")
    return bool(text) and all(32 <= byte < 127 for byte in text)
