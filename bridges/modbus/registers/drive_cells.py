"""Places of values in a drive's map, and which entry a register or a bit belongs to."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from bridges.modbus.protocol.pdu import Code, Refused, Span, Table
from bridges.modbus.registers.cells import Cell
from bridges.modbus.registers.drive_map import CONTROL, STATUS, DriveMap, RegisterPlace
from bridges.modbus.registers.register_map import crc_of
from hil.vocab.desk_protocol import DeviceInfo
from hil.vocab.drive_words import TAKEN, TOLD

MAP_VERSION = 1
"""Version of the format of maps."""
_ABOUT = {**TOLD, **TAKEN, **STATUS, **CONTROL}
_UNITS = {"deg": "deg", "rpm": "rpm", "A": "A", "s": "rpm/s"}


class MapEntry(NamedTuple):
    """Entry of a map. ``name``: without its room's; ``is_taken``: a client may write it."""

    name: str
    place: RegisterPlace
    is_taken: bool
    is_parameter: bool


@dataclass(frozen=True, eq=False)
class DriveCells:
    """Map of a drive as a unit serves it, ``bridges.modbus.registers.registers_protocol.UnitMap``."""

    of: DriveMap
    info: DeviceInfo
    notes: Sequence[str] = ()
    version: int = MAP_VERSION

    @property
    def identity(self) -> Mapping[str, str]:
        return self.of.identity

    @cached_property
    def entries(self) -> Sequence[MapEntry]:
        """All entries."""
        rooms = (
            (self.of.values, None, False),
            (self.of.status, False, False),
            (self.of.control, True, False),
            (self.of.parameters, True, True),
        )
        return [
            MapEntry(name, place, name in TAKEN if taken is None else taken, is_parameter)
            for room, taken, is_parameter in rooms
            for name, place in room.items()
        ]

    @cached_property
    def at(self) -> Mapping[tuple[Table, int], Sequence[MapEntry]]:
        """Entries of each register or bit that has some: a value, or bits."""
        at = defaultdict(list)
        for entry in self.entries:
            for address in range(entry.place.address, entry.place.address + entry.place.width):
                at[entry.place.table, address].append(entry)
        return dict(at)

    def check(self, span: Span) -> None:
        """Check that all of a span is there. Raises Refused."""
        for address in range(span.address, span.address + span.count):
            if (span.table, address) not in self.at:
                where = f"{span.table.value.removesuffix('s')} {address}"
                raise Refused(Code.ILLEGAL_DATA_ADDRESS, f"there is no {where}")

    @cached_property
    def cells(self) -> Sequence[Cell]:
        """Contents of a map: values, single bits, and words of bits."""
        found = []
        for (table, address), entries in self.at.items():
            first = entries[0]
            if first.place.bit is not None:
                found.append(_word(table, address, entries))
            elif address == first.place.address:
                found.append(self._cell(first))
        tables = list(Table)
        return sorted(found, key=lambda cell: (tables.index(cell.table), cell.address))

    def _cell(self, entry: MapEntry) -> Cell:
        place, field = entry.place, self.info.fields.get(entry.name) if entry.is_parameter else None
        unit = field.unit if field else "" if place.is_bit else _UNITS.get(entry.name.rpartition("_")[2], "")
        if place.scale != 1:
            unit = f"{place.scale:g} {unit}".rstrip()
        about = field.meaning if field else _about(entry)
        return Cell(place.table, place.address, place.type, entry.name, unit, about, entry.is_taken)

    @cached_property
    def crc(self) -> int:
        """CRC-32 of the map, with the order of words."""
        return crc_of(self.cells, MAP_VERSION << 1 | self.of.is_low_first)


def _about(entry: MapEntry) -> str:
    about = _ABOUT.get(entry.name, "")
    return (
        about.replace("when it becomes 1:", "with each 1 that is written:") if entry.place.on_write else about
    )


def _word(table: Table, address: int, entries: Sequence[MapEntry]) -> Cell:
    by_bit = sorted(entries, key=lambda entry: entry.place.bit or 0)
    names = ", ".join(f"{entry.place.bit} {entry.name}" for entry in by_bit)
    abouts = "; ".join(f"{entry.name}: {_about(entry)}" for entry in by_bit)
    is_taken = any(entry.is_taken for entry in entries)
    return Cell(table, address, "u16", f"bits {names}", "", abouts, is_taken)
