"""Drive whose objects are those of a maker's file: what CiA 402 says of them is bound to the axis, all else
are plain cells, or what lines of a configuration say."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.cia402 import objects
from bridges.can.canopen.cia402.drive_context import MakersWays
from bridges.can.canopen.cia402.drive_entries import entries_of, modes_of
from bridges.can.canopen.cia402.maker_units import DefaultScale, factors_of, units_with
from bridges.can.canopen.cia402.motor_axis import MotorAxis
from bridges.can.canopen.cia402.profile_drive import DriveObjects, ProfileDrive
from bridges.can.canopen.cia402_words import INTERPOLATED_POSITION, mode_bit
from bridges.can.canopen.master.drive_units import NO_UNITS, GivenUnits
from bridges.can.canopen.node.application import Access, DataType, Entry, SdoAbort, Value
from bridges.can.canopen.node.canopen_node import CanOpenNode
from bridges.can.canopen.node.communication_entries import (
    MAPPED,
    Identity,
    communication_entries,
    mapping_entries,
)
from bridges.can.canopen.node.data_types import REALS, bounds_of, of_sign, size_of
from bridges.can.canopen.node.eds_mappings import mapped_by_default
from bridges.can.canopen.node.eds_reader import EdsDevice
from bridges.can.canopen.node.pdos import RPDOS, TPDOS

Key = tuple[int, int]
_PROFILE = 0x2000
_COUNTS = 0x608F
_FACTORS = (0x6091, 0x6092, 0x6096, 0x6097)
_COMMANDED = frozenset((0x6040, 0x6060, 0x6071, 0x607A, 0x60B0, 0x60B1, 0x60B2, 0x60C1, 0x60FF))
"""Objects that a master writes again and again, which 1010h does not keep."""
_IDENTITY, _STORES = 0x1018, (0x1010, 0x1011)


class FieldLine(NamedTuple):
    """Object that tells a field of the axis, in ``scale`` units of one of the field's."""

    name: str
    scale: float


class LikeLine(NamedTuple):
    """Object that is another one, ``scale`` times as much."""

    of: Key
    scale: float


@dataclass(frozen=True)
class MakerLines:
    """Lines of a configuration about a maker's drive. ``values``: first values in place of the file's."""

    units: GivenUnits = NO_UNITS
    values: Mapping[Key, Value] = field(default_factory=dict)
    bound: Mapping[Key, FieldLine | LikeLine] = field(default_factory=dict)


def given_values(device: EdsDevice, lines: MakerLines) -> Mapping[Key, Value]:
    """Values by the file and the lines, of those objects of which one of them has any."""
    found = {key: device.entries[key].default for key in device.given}
    return found | dict(lines.values)


def with_values(device: EdsDevice, values: Mapping[Key, Value]) -> dict[Key, Entry]:
    """Entries of a file with first values of lines, which no node id is added to."""
    return dict(device.entries) | {
        key: replace(device.entries[key], default=value, adds_node_id=False) for key, value in values.items()
    }


def identity_of(device: EdsDevice, lines: MakerLines, serial: int) -> Identity:
    """Identity of a node of this file: 1018h, or else what it says of the device."""
    given, info = given_values(device, lines), device.info

    def number(subindex: int, otherwise: int) -> int:
        value = given.get((_IDENTITY, subindex))
        return value if isinstance(value, int) and value else otherwise

    name = given.get((0x1008, 0))
    return Identity(
        number(1, info.vendor_number),
        number(2, info.product_number),
        number(3, info.revision_number),
        number(4, serial),
        name.decode("utf-8", "replace") if isinstance(name, bytes) and name else info.product_name,
        vendor_name=info.vendor_name,
        bit_rates=info.bit_rates or Identity(0, 0, 0, 0, "").bit_rates,
        has_lss=info.has_lss,
    )


def maker_objects(axis: MotorAxis, device: EdsDevice, lines: MakerLines, identity: Identity) -> DriveObjects:
    """Make the objects of a drive: the file's, and hidden ones that the drive itself needs.

    Raises:
        UnitsUnknown: neither file nor lines say what a turn is.
    """
    given = given_values(device, lines)

    def number(index: int, subindex: int) -> int | None:
        value = given.get((index, subindex))
        return value if isinstance(value, int) else None

    factors = factors_of(number, lines.units)
    scale = DefaultScale(units_with(factors, number))
    own = {
        key: replace(entry, default=scale.of(entry.index, entry.default))
        if isinstance(entry.default, int)
        else entry
        for entry in entries_of(axis)
        if entry.index >= _PROFILE and (key := (entry.index, entry.subindex))
    }
    common = {
        (entry.index, entry.subindex): entry for entry in communication_entries(objects.SERVO_DRIVE, identity)
    }
    base = common | own
    own_entries = with_values(device, lines.values)
    ways = _default_ways(own_entries)
    seen = {
        key: _entry(entry, base.get(key), given.get(key), ways.get(key, ""), is_bound=key in lines.bound)
        for key, entry in own_entries.items()
    }
    _complete_counts(seen, given)
    hidden = base | {(each.index, each.subindex): each for each in _of_pdos(seen)}
    entries = [
        *seen.values(),
        *(
            replace(entry, is_hidden=True, mapping="", is_stored=False)
            for key, entry in hidden.items()
            if key not in seen
        ),
    ]
    bits = number(0x6502, 0)
    modes = (*modes_of(axis), INTERPOLATED_POSITION) if _interpolates(axis, seen) else modes_of(axis)
    if bits:
        modes = tuple(mode for mode in modes if bits & mode_bit(mode))
    names = dict(device.names) | {index: "" for index, _ in hidden if index not in device.names}
    return DriveObjects(entries, names, modes, MakersWays(factors, zero_is_off=True))


def _interpolates(axis: MotorAxis, seen: Mapping[Key, Entry]) -> bool:
    return axis.follows_paths and (0x60C1, 1) in seen


def _entry(entry: Entry, base: Entry | None, given: Value | None, way: str, *, is_bound: bool) -> Entry:
    """Entry of the file as the node has it. ``base``: hil's own of the same key."""
    if base is not None and base.data_type is not entry.data_type:
        entry = _with_sign(entry, base.data_type)
        given = of_sign(entry.data_type, given) if isinstance(given, int) else given
    is_writable = entry.access in (Access.RW, Access.WO)
    default, adds_node_id = entry.default, entry.adds_node_id
    is_alike = base is not None and isinstance(base.default, bytes) == isinstance(entry.default, bytes)
    if given is not None:
        default = given
    elif base is not None and is_alike:
        default, adds_node_id = _within(entry, _fitting(base.default, entry.data_type)), base.adds_node_id
    else:
        default = _within(entry, default)
    if base is not None:
        is_stored = base.is_stored
    else:
        is_stored = is_writable and entry.index >= _PROFILE and entry.index not in _COMMANDED
    is_live = is_bound or (base is not None and base.is_live and is_alike) or _is_told(entry)
    low = entry.low
    if entry.index in _FACTORS and entry.subindex:
        low = max(low or 1, 1)
    mapping = "both" if {way, entry.mapping} == {"rpdo", "tpdo"} or "both" in (way, entry.mapping) else ""
    return replace(
        entry,
        default=default,
        adds_node_id=adds_node_id,
        low=low,
        mapping=mapping or entry.mapping or way,
        is_stored=is_stored and not is_bound,
        is_live=is_live,
    )


def _with_sign(entry: Entry, data_type: DataType) -> Entry:
    """Entry with the sign that CiA has for it, where a file has the same length without one, or with one."""
    low, high = bounds_of(data_type)
    if low == high or size_of(entry.data_type) != size_of(data_type) or entry.data_type in REALS:
        return entry
    least = None if entry.low is None or not low <= entry.low <= high else entry.low
    most = None if entry.high is None or not low <= entry.high <= high else entry.high
    return replace(entry, data_type=data_type, low=least, high=most)


def _is_told(entry: Entry) -> bool:
    """True of an object of communication that the node tells, of which a file may have more than hil."""
    return entry.index == 0x1003 or (entry.index in _STORES and entry.access in (Access.RW, Access.WO))


def _fitting(value: Value, data_type: DataType) -> Value:
    """Value that a type can have and that is nearest."""
    if isinstance(value, bytes) or data_type in REALS or not size_of(data_type):
        return value
    low, high = bounds_of(data_type)
    return max(low, min(high, round(value)))


def _within(entry: Entry, value: Value) -> Value:
    """Value within the limits of the file that is nearest."""
    if isinstance(value, bytes):
        return value
    value = value if entry.low is None else max(value, entry.low)
    return value if entry.high is None else min(value, entry.high)


def _default_ways(entries: Mapping[Key, Entry]) -> Mapping[Key, str]:
    """PDOs of what is mapped at first, whatever its ``PDOMapping`` says: the maker's own drive does it."""
    ways: dict[Key, str] = {}
    for _, target, is_received in mapped_by_default(entries):
        way = "rpdo" if is_received else "tpdo"
        ways[target] = way if ways.get(target, way) == way else "both"
    return ways


def _complete_counts(seen: dict[Key, Entry], given: Mapping[Key, Value]) -> None:
    """Give sub-index 0 of an object of which the file has no number its highest sub-index."""
    highest: dict[int, int] = {}
    for index, subindex in seen:
        highest[index] = max(highest.get(index, 0), subindex)
    for index, most in highest.items():
        key = index, 0
        is_count = index not in range(0x1600, 0x1800) and index not in range(0x1A00, 0x1C00)
        if most and key in seen and key not in given and is_count and not seen[key].is_live:
            seen[key] = replace(seen[key], default=most)


def _of_pdos(seen: Mapping[Key, Entry]) -> Iterator[Entry]:
    """Entries that a PDO of the file needs, of which it may have fewer."""
    for index in {index for index, _ in seen}:
        if index in RPDOS or index in TPDOS:
            for subindex, data_type in ((1, _U32), (2, _U8), (3, _U16), (5, _U16), (6, _U8)):
                default = _NOT_VALID if subindex == 1 else 255 if subindex == 2 else 0
                yield Entry(index, subindex, "", data_type, Access.RW, default)
            there = {sub for at, sub in seen if at == index + 0x200}
            if not there:
                yield from mapping_entries(index + 0x200, ())
            elif 0 in there:
                count = seen[index + 0x200, 0].default
                most = min(count, MAPPED) if isinstance(count, int) else 0
                yield from (
                    Entry(index + 0x200, sub, "", _U32, Access.RO)
                    for sub in range(1, most + 1)
                    if sub not in there
                )


_U8, _U16, _U32 = DataType.UNSIGNED8, DataType.UNSIGNED16, DataType.UNSIGNED32
_NOT_VALID = 1 << 31


class MakerDrive(ProfileDrive):
    """Drive of a maker's file, an ``Application`` as its base."""

    def __init__(
        self, axis: MotorAxis, services: CanOpenNode, device: EdsDevice, lines: MakerLines, identity: Identity
    ) -> None:
        own = maker_objects(axis, device, lines, identity)
        self._entries = {(entry.index, entry.subindex): entry for entry in own.entries}
        self._bound = lines.bound
        self._likes = {of.of: key for key, of in lines.bound.items() if isinstance(of, LikeLine)}
        super().__init__(axis, services, own)
        counts, turns = (given_values(device, lines).get((_COUNTS, each)) for each in (1, 2))
        if isinstance(counts, int) and counts > 1:
            self._encoder_counts = counts / (turns if isinstance(turns, int) and turns > 0 else 1)

    def read(self, index: int, subindex: int, now_ns: int) -> Value:
        bound = self._bound.get((index, subindex))
        if bound is None:
            return _fitting(super().read(index, subindex, now_ns), self._entries[index, subindex].data_type)
        if isinstance(bound, FieldLine):
            value = self._axis.measured(bound.name) * bound.scale
        else:
            value = self._value_of(bound.of, now_ns) * bound.scale
        entry = self._entries[index, subindex]
        return value if entry.data_type in REALS else _fitting(value, entry.data_type)

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        bound = self._bound.get((index, subindex))
        if bound is None:
            super().write(index, subindex, value, now_ns)
        elif isinstance(bound, LikeLine) and not isinstance(value, bytes):
            self._write_like(bound, value, now_ns)

    def _write_like(self, bound: LikeLine, value: float, now_ns: int) -> None:
        """Write the object that another one stands for."""
        entry = self._entries[bound.of]
        target = round(value / bound.scale)
        low, high = bounds_of(entry.data_type)
        if target > (high if entry.high is None else entry.high):
            raise SdoAbort(AbortCode.TOO_HIGH)
        if target < (low if entry.low is None else entry.low):
            raise SdoAbort(AbortCode.TOO_LOW)
        before = self._services.value(*bound.of)
        self._services.set_value(*bound.of, target)
        try:
            super().write(*bound.of, target, now_ns)
        except SdoAbort:
            self._services.set_value(*bound.of, before)
            raise

    def _value_of(self, key: Key, now_ns: int) -> float:
        entry = self._entries[key]
        value = super().read(*key, now_ns) if entry.is_live else self._services.value(*key)
        assert not isinstance(value, bytes), "the configuration's check wants a number"
        return value
