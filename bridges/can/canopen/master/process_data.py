"""Process data of a drive: which objects its PDOs carry, as mappings, and the values of a frame of them.

Sources: CiA 301, 7.5.2.33 to 7.5.2.36 (communication and mapping parameters).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from bridges.can.canopen import cia402_words
from bridges.can.canopen.can_ids import INVALID


@dataclass(frozen=True)
class MappedValue:
    """Object that a PDO carries. ``field``: name of its value here."""

    index: int
    bits: int
    is_signed: bool
    field: str

    @property
    def word(self) -> int:
        """Word of a mapping parameter."""
        return self.index << 16 | self.bits


STATUSWORD = MappedValue(cia402_words.STATUSWORD, 16, False, "statusword")
POSITION = MappedValue(0x6064, 32, True, "position")
MODE = MappedValue(cia402_words.MODE_DISPLAY, 8, True, "mode")
VELOCITY = MappedValue(0x606C, 32, True, "velocity")
CURRENT = MappedValue(0x6078, 16, True, "current")
ERROR = MappedValue(cia402_words.ERROR_CODE, 16, False, "error")
TARGET = MappedValue(cia402_words.TARGET_POSITION, 32, True, "target")
TOLD = ((STATUSWORD, POSITION, MODE), (VELOCITY, CURRENT, ERROR))
"""Objects of TPDO 1 and 2, 7 and 8 bytes; those behind the first two are left out where there are none."""
NEEDED = (STATUSWORD, POSITION)


def packed_target(units: int) -> bytes:
    """Data of the RPDO with the set-point."""
    return units.to_bytes(4, "little", signed=True)


@dataclass
class SyncBeat:
    """Times of SYNCs. ``synced_ns``: of the last, never later than it was."""

    synced_ns: int = 0
    _counts_as_ns: int = 0

    def next(self, now_ns: int, period_ns: int) -> int:
        """Time that the SYNC of now counts as: a period after the one before, however both came, unless that
        is too far from now by half of one. So set-points are as far apart as a drive takes them to be."""
        due_ns = self._counts_as_ns + period_ns
        self._counts_as_ns = due_ns if abs(due_ns - now_ns) <= period_ns // 2 else now_ns
        self.synced_ns = min(self._counts_as_ns, now_ns)
        return self._counts_as_ns


def values_in(objects: Sequence[MappedValue], data: bytes) -> dict[str, int] | None:
    """Values of a frame by the names of their fields; None: it is too short for them."""
    if len(data) * 8 < sum(each.bits for each in objects):
        return None
    values, at = {}, 0
    for each in objects:
        end = at + each.bits // 8
        values[each.field] = int.from_bytes(data[at:end], "little", signed=each.is_signed)
        at = end
    return values


@dataclass(frozen=True)
class ObjectWrite:
    """Write of a number of ``size`` bytes to an object."""

    index: int
    subindex: int
    value: int
    size: int


def mapping_writes(
    identifier: int, number: int, objects: Sequence[MappedValue], transmission: int, *, is_rpdo: bool = False
) -> Iterator[ObjectWrite]:
    """Writes that map a PDO again: it is switched off, its map is emptied, filled and counted, and it is
    switched on. ``identifier``: with its bits; ``number``: 0 to 3; ``transmission``: type of transmission."""
    communication = parameter_index(number, is_rpdo=is_rpdo)
    mapping = communication + 0x200
    yield ObjectWrite(communication, 1, identifier | INVALID, 4)
    yield ObjectWrite(communication, 2, transmission, 1)
    yield ObjectWrite(mapping, 0, 0, 1)
    for at, each in enumerate(objects, 1):
        yield ObjectWrite(mapping, at, each.word, 4)
    yield ObjectWrite(mapping, 0, len(objects), 1)
    yield ObjectWrite(communication, 1, identifier, 4)


def parameter_index(number: int, *, is_rpdo: bool = False) -> int:
    """Index of a PDO's communication parameter. ``number``: 0 to 3."""
    return (0x1400 if is_rpdo else 0x1800) + number
