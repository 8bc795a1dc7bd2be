"""Values of PDOs in words, once it was seen or told what is mapped.

Source: CiA 301, 7.5.2.35 to 7.5.2.38; 7.3.5 for the identifiers that nodes have at first.
"""

from collections.abc import Iterable
from typing import NamedTuple

from bridges.can.canopen.can_ids import INVALID
from bridges.can.canopen.words.object_words import ObjectWords

_FIRST = {"TPDO": 0x180, "RPDO": 0x200}
_COMMUNICATION, _MAPPING = {"RPDO": 0x1400, "TPDO": 0x1800}, {"RPDO": 0x1600, "TPDO": 0x1A00}
_ID_MASK = 0x7FF
_MOST = 4
"""Number of PDOs of each kind that have identifiers at first."""
_COUNT = 512


class MappedObject(NamedTuple):
    """Part of a PDO's data, ``bits`` long."""

    object_index: int
    subindex: int
    bits: int


class PdoName(NamedTuple):
    """PDO of a node: RPDO or TPDO, and its number from 1 on."""

    node: int
    kind: str
    number: int

    def __str__(self) -> str:
        return f"{self.kind}{self.number} of {self.node}"


class PdoWords:
    """PDOs of all nodes on a bus, with what was seen of their identifiers and mappings."""

    def __init__(self) -> None:
        self._identifiers: dict[int, PdoName] = {}
        self._moved_away: set[int] = set()
        self._mapped: dict[PdoName, dict[int, int]] = {}
        """Values of the mapping's sub-indices, 0 with their number."""

    def note(self, node: int, index: int, subindex: int, data: bytes) -> None:
        """Note what an object of a node has, if it is about a PDO."""
        value = int.from_bytes(data, "little")
        for kind in _FIRST:
            number = index - _MAPPING[kind] + 1
            if 1 <= number <= _COUNT and len(data) <= 4:
                self._mapped.setdefault(PdoName(node, kind, number), {})[subindex] = value
            number = index - _COMMUNICATION[kind] + 1
            if 1 <= number <= _COUNT and subindex == 1 and len(data) == 4:
                self._set_identifier(PdoName(node, kind, number), value)

    def find(self, identifier: int) -> PdoName | None:
        """PDO that an identifier is of, as far as is known."""
        if known := self._identifiers.get(identifier):
            return known
        node, offset = identifier & 0x7F, identifier & ~0x7F
        if identifier in self._moved_away or not node or not 0x180 <= offset <= 0x500:
            return None
        number, rest = divmod(offset - 0x180, 0x100)
        return PdoName(node, "RPDO" if rest else "TPDO", number + 1)

    def say(self, pdo: PdoName, data: bytes, objects: ObjectWords) -> str:
        """Say the values; empty where the mapping is not known."""
        mapped, at = list(self.mapping(pdo)), 0
        if not mapped:
            return ""
        said: list[str] = []
        bits, number = 8 * len(data), int.from_bytes(data, "little")
        for part in mapped:
            if at + part.bits > bits:
                said.append(f"{len(data)} bytes of {sum(each.bits for each in mapped) // 8}")
                break
            value = number >> at & (1 << part.bits) - 1
            at += part.bits
            if part.object_index >= 0x20:  # below are types, which fill a gap
                raw = value.to_bytes((part.bits + 7) // 8, "little")
                name = objects.short(part.object_index, part.subindex)
                said.append(f"{name} {objects.value(part.object_index, part.subindex, raw)}")
        return ", ".join(said)

    def _set_identifier(self, pdo: PdoName, value: int) -> None:
        for identifier, known in list(self._identifiers.items()):
            if known == pdo:
                del self._identifiers[identifier]
        if pdo.number <= _MOST:
            self._moved_away.add(_FIRST[pdo.kind] + 0x100 * (pdo.number - 1) + pdo.node)
        if not value & INVALID:
            self._identifiers[value & _ID_MASK] = pdo

    def mapping(self, pdo: PdoName) -> Iterable[MappedObject]:
        """Parts of a PDO's data, as far as is known."""
        mapped = self._mapped.get(pdo, {})
        for at in range(1, min(mapped.get(0, 0), 64) + 1):
            if at not in mapped:
                return
            value = mapped[at]
            yield MappedObject(value >> 16, value >> 8 & 0xFF, value & 0xFF)
