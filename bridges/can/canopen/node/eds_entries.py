"""Entries of a maker's file: type, access, first value and limits of each, and what is wrong with them.

Source: CiA 306-1 version 1.3.0, 4.6.3 (objects); CiA 301 version 4.2.0, 7.4.7.1 (types).
"""

from collections.abc import Callable
from functools import lru_cache

from bridges.can.canopen.eds_sections import EdsFields, number_of, without_comment
from bridges.can.canopen.node.application import Access, DataType, Entry, Value
from bridges.can.canopen.node.data_types import REALS, bounds_of, of_sign, real_of_bits, size_of

DOMAIN = 2
"""``ObjectType`` of an object that has no other type."""
_WAYS = {
    "ro": (Access.RO, "tpdo"),
    "const": (Access.CONST, "tpdo"),
    "wo": (Access.WO, "rpdo"),
    "rw": (Access.RW, "both"),
    "rwr": (Access.RW, "tpdo"),
    "rww": (Access.RW, "rpdo"),
}
"""Access and PDOs by an ``AccessType``."""
_TEXTS = (DataType.VISIBLE_STRING, DataType.UNICODE_STRING)
_NOTHING = ("n/a", "n.a.", "-", "none")
"""Words of tools in place of a value."""
_BOOLEANS = {"true": "1", "false": "0"}
_BYTES = (DataType.OCTET_STRING, DataType.DOMAIN)
Key = tuple[int, int]
"""Index and sub-index."""
_TYPES = {int(each): each for each in DataType} | {0x0C: DataType.UNSIGNED48, 0x0D: DataType.UNSIGNED48}
"""Types by their numbers; times of day and differences of them are six bytes."""


class EntryReader:
    """Reader of entries. ``add`` is told of a problem: its place in the text, a message, a remedy."""

    def __init__(self, add: Callable[[int, str, str], None]) -> None:
        self._add = add
        self.given: set[Key] = set()
        """Keys of the entries whose values are in the file."""
        self.spots: dict[Key, int] = {}
        """Places of these values."""

    def read(self, key: Key, fields: EdsFields, place: int, *, is_count: bool) -> Entry | None:
        """Read an entry; None: it is none, which was told. ``place``: that of its section; ``is_count``: it
        counts the sub-indices of its object."""
        is_domain = "datatype" not in fields and plain_number(fields, "objecttype") == DOMAIN
        data_type = DataType.DOMAIN if is_domain else _TYPES.get(plain_number(fields, "datatype"))
        if data_type is None:
            at = fields["datatype"][1] if "datatype" in fields else place
            said = f"the type {fields['datatype'][0]}" if "datatype" in fields else "an object without a type"
            remedy = "write its DataType, as in DataType=0x0007 for UNSIGNED32"
            self._add(at, f"{shown_key(key)} has {said}, which no node can have", remedy)
            return None
        access, way = self._access(key, fields, is_count=is_count)
        default, adds_node_id = self._value(key, data_type, fields)
        low, high = self._limits(key, data_type, fields)
        return Entry(
            *key,
            text_of_field(fields, "parametername") or shown_key(key),
            data_type,
            access,
            default,
            low,
            high,
            way if plain_number(fields, "pdomapping") else "",
            adds_node_id=adds_node_id,
        )

    def _access(self, key: Key, fields: EdsFields, *, is_count: bool) -> tuple[Access, str]:
        text, at = fields.get("accesstype", ("", 0))
        found = _WAYS.get(without_comment(text).lower())
        if found is None:
            if text:
                remedy = "write ro, wo, rw, rwr, rww or const"
                self._add(at, f"{shown_key(key)} has the access {text!r}, which there is not", remedy)
            return Access.RO if is_count else Access.RW, "both"
        return found

    def _value(self, key: Key, data_type: DataType, fields: EdsFields) -> tuple[Value, bool]:
        """First value, and whether the node's id is added to it."""
        for name in ("parametervalue", "defaultvalue"):
            text, at = fields.get(name, ("", 0))
            if text and text.lower() not in _NOTHING:
                break
        else:
            return (0 if size_of(data_type) else b""), False
        self.spots[key] = at
        if data_type in _TEXTS:
            self.given.add(key)
            return (text.encode() if data_type is _TEXTS[0] else text.encode("utf-16-le")), False
        if data_type in _BYTES:
            return self._bytes(key, text, at), False
        if data_type in REALS and (real := _real(text, data_type)) is not None:
            self.given.add(key)
            return real, False
        plain = without_comment(text)
        plain = _BOOLEANS.get(plain.lower(), plain) if data_type is DataType.BOOLEAN else plain
        whole, is_number = _whole_of(plain, data_type), True
        if whole is None and number_of(plain, 0) is None:
            is_number = (real := _real(plain, DataType.REAL64)) is not None and float(real).is_integer()
            whole = _whole_of(str(int(real or 0)), data_type) if is_number else None  # some write 0.0
        if whole is not None:
            self.given.add(key)
            return whole
        low, high = bounds_of(data_type)
        remedy = f"write {low} to {high}, or the type that it has"
        message = f"{shown_key(key)} is {data_type.name}, which cannot be {plain}"
        if not is_number:
            remedy = "write a number, as in 100, 0x64 or $NODEID+0x200"
            message = f"{shown_key(key)} is {data_type.name}, and {text!r} is no number"
        self._add(at, message, remedy)
        return 0, False

    def _bytes(self, key: Key, text: str, at: int) -> bytes:
        try:
            found = bytes.fromhex(without_comment(text).removeprefix("0x"))
        except ValueError:
            return b""  # as that of a domain, which has a file's name or a remark
        self.given.add(key)
        return found

    def _limits(self, key: Key, data_type: DataType, fields: EdsFields) -> tuple[float | None, float | None]:
        if not size_of(data_type) or ("lowlimit" not in fields and "highlimit" not in fields):
            return None, None
        low, high = (self._limit(key, data_type, fields, name) for name in ("lowlimit", "highlimit"))
        if low is not None and high is not None and low > high:
            at = fields["lowlimit"][1]
            message = f"{shown_key(key)} has a LowLimit of {low:g}, above its HighLimit of {high:g}"
            self._add(at, message, "exchange the two, or leave them empty")
        return low, high

    def _limit(self, key: Key, data_type: DataType, fields: EdsFields, name: str) -> float | None:
        text, at = fields.get(name, ("", 0))
        value, is_number = _limit_of(text, data_type)
        if not is_number:
            remedy = "write a number, or leave it empty"
            self._add(at, f"{shown_key(key)} has {text!r} as a limit, which is no number", remedy)
        return value


def shown_key(key: Key) -> str:
    """Name an entry by its index and sub-index."""
    return f"{key[0]:04X}h:{key[1]}"


def text_of_field(fields: EdsFields, key: str) -> str:
    """Text of an entry; empty where there is none."""
    return fields.get(key, ("", 0))[0].strip()


def plain_number(fields: EdsFields, key: str) -> int:
    """Number of an entry; 0 where there is none that is one."""
    found = fields.get(key)
    return 0 if found is None else _plain(found[0])


@lru_cache(maxsize=1024)
def _plain(text: str) -> int:
    return number_of(without_comment(text), 0) or 0


@lru_cache(maxsize=4096)
def _limit_of(text: str, data_type: DataType) -> tuple[float | None, bool]:
    """Limit that a text is, and whether it is one, or empty. None: there is none, or no value reaches it."""
    plain = without_comment(text)
    if not plain:
        return None, True
    if data_type in REALS:
        real = _real(plain, data_type)
        return real, real is not None
    if (whole := number_of(plain, 0)) is None:
        return None, False
    low, high = bounds_of(data_type)
    value = of_sign(data_type, whole)
    return (value if low <= value <= high else None), True


@lru_cache(maxsize=4096)
def _whole_of(text: str, data_type: DataType) -> tuple[int, bool] | None:
    """Whole number that a text is for a type, and whether the node's id is added to it; None: it is none, or
    the type cannot have it."""
    value = number_of(text, 0)
    with_id = number_of(text, 1) if "$" in text else value
    if value is None or with_id is None:
        return None
    low, high = bounds_of(data_type)
    signed = of_sign(data_type, value)
    return (signed, with_id != value) if low <= signed <= high else None


def _real(text: str, data_type: DataType) -> float | None:
    """Real number: decimal, or the bits of one in hexadecimal; None: it is none."""
    plain = without_comment(text).strip()
    try:
        if plain.lower().startswith("0x"):
            return real_of_bits(data_type, int(plain, 16))
        return float(plain)
    except (ValueError, OverflowError):
        return None
