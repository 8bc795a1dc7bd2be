"""PDO mappings of a file: which of their values no node could take.

Source: CiA 301 version 4.2.0, 7.5.2.36 and 7.5.2.38.
"""

from collections.abc import Iterator, Mapping

from bridges.can.canopen.node.application import Access, Entry
from bridges.can.canopen.node.data_types import STRUCTS, size_of
from bridges.can.canopen.node.pdo import DUMMIES
from bridges.can.frames.can_frame import DATA_MAX

_RPDOS, _TPDOS = range(0x1600, 0x1800), range(0x1A00, 0x1C00)
_MOST = 64
_DUMMIES = frozenset(int(each) for each in DUMMIES)
_Key = tuple[int, int]


def mapped_by_default(entries: Mapping[_Key, Entry]) -> Iterator[tuple[_Key, _Key, bool]]:
    """Go through what the mappings have at first: where each value stands, the index and sub-index that it
    names, and whether it is in a PDO that the node receives."""
    for index in sorted({index for index, _ in entries}):
        if index not in _RPDOS and index not in _TPDOS:
            continue
        for subindex in range(1, _count(entries, index) + 1):
            value = _number(entries, (index, subindex))
            if value:
                yield (index, subindex), (value >> 16, value >> 8 & 0xFF), index in _RPDOS


def mapping_problems(entries: Mapping[_Key, Entry]) -> Iterator[tuple[_Key, str, str]]:
    """Find what cannot be mapped: where it stands, a message, a remedy."""
    sizes: dict[int, int] = {}
    for place, target, is_received in mapped_by_default(entries):
        bits = _number(entries, place) & 0xFF
        sizes[place[0]] = sizes.get(place[0], 0) + bits
        where = f"{target[0]:04X}h:{target[1]}"
        if is_received and target[0] in _DUMMIES:
            continue
        entry = entries.get(target)
        if entry is None:
            yield place, f"it maps {where}, which is not in the file", f"add {where}, or map another"
        elif entry.data_type not in STRUCTS or not size_of(entry.data_type):
            yield place, f"it maps {where}, whose length is not fixed", "map a number"
        elif bits != 8 * size_of(entry.data_type):
            length = 8 * size_of(entry.data_type)
            remedy = f"write 0x{target[0]:04X}{target[1]:02X}{length:02X}"
            yield place, f"it maps {bits} bits of {where}, which has {length}", remedy
        elif is_received and entry.access in (Access.RO, Access.CONST):
            yield place, f"it receives {where}, which is {entry.access}", "map what can be written"
        elif not is_received and entry.access is Access.WO:
            yield place, f"it sends {where}, which can only be written", "map what can be read"
    for index, bits in sizes.items():
        if bits > 8 * DATA_MAX:
            message = f"{index:04X}h maps {bits} bits, and a PDO has 64"
            yield (index, 0), message, "map less"


def _count(entries: Mapping[_Key, Entry], index: int) -> int:
    return min(_number(entries, (index, 0)), _MOST)


def _number(entries: Mapping[_Key, Entry], key: _Key) -> int:
    entry = entries.get(key)
    return entry.default if entry is not None and isinstance(entry.default, int) else 0
