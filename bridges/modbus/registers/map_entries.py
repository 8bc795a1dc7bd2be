"""Rows of a map of version 2, and which of them a register or a bit belongs to."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

from bridges.modbus.protocol.pdu import Refused, Span, Table
from bridges.modbus.registers.cells import Cell
from bridges.modbus.registers.drive_map import CONTROL, STATUS, DriveMap, RegisterPlace
from bridges.modbus.registers.map_parts import FREE, BlockPart, CellPart, CommandPart, StatePart, WriteGuard
from bridges.modbus.registers.register_map import crc_of
from hil.vocab.desk_protocol import DeviceInfo
from hil.vocab.drive_words import MORE_TAKEN, MORE_TOLD, TAKEN, TOLD
from hil.vocab.late_dataclass import dataclass

_ABOUT = {**TOLD, **TAKEN, **MORE_TOLD, **MORE_TAKEN}
_UNITS = {"deg": "deg", "rpm": "rpm", "A": "A", "s": "rpm/s"}


class MapRow(NamedTuple):
    """Row of a map. ``room``: value, status, control, parameter, cell, command or state; ``part``: what it is
    beside its place."""

    room: str
    name: str
    place: RegisterPlace
    is_read: bool
    is_taken: bool
    part: CellPart | CommandPart | StatePart | None = None
    guard: WriteGuard = FREE

    @property
    def about(self) -> str:
        """Meaning, for people."""
        if self.room in ("status", "control"):
            return {**STATUS, **CONTROL}.get(self.name, "")
        return (self.part.about if self.part else "") or _ABOUT.get(self.name, "")


@dataclass(frozen=True, eq=False)
class MapEntries:
    """Map of version 2 as a unit serves it, ``bridges.modbus.registers.registers_protocol.UnitMap``."""

    of: DriveMap
    info: DeviceInfo
    notes: Sequence[str] = ()
    version: int = 2

    @property
    def identity(self) -> Mapping[str, str]:
        return self.of.identity

    @cached_property
    def rows(self) -> Sequence[MapRow]:
        """All rows."""
        return list(self._rows())

    def _rows(self) -> Iterator[MapRow]:
        of, parts = self.of, self.of.parts
        for name, place in (*of.values.items(), *parts.also):
            yield MapRow("value", name, place, True, name in TAKEN or name in MORE_TAKEN)
        for name, place in of.status.items():
            yield MapRow("status", name, place, True, False)
        for name, place in of.control.items():
            yield MapRow("control", name, place, True, True)
        for name, place in of.parameters.items():
            yield MapRow("parameter", name, place, True, True)
        for name, (place, cell) in parts.cells.items():
            yield MapRow("cell", name, place, cell.is_read, cell.is_written, cell, cell.guard)
        for name, (place, command) in parts.commands.items():
            yield MapRow("command", name, place, True, True, command, command.guard)
        for name, (place, state) in parts.states.items():
            yield MapRow("state", name, place, True, False, state)

    @cached_property
    def at(self) -> Mapping[tuple[Table, int], Sequence[MapRow]]:
        """Rows of each register or bit that has some."""
        at = defaultdict(list)
        for row in self.rows:
            for address in range(row.place.address, row.place.address + row.place.width):
                at[row.place.table, address].append(row)
        return dict(at)

    @cached_property
    def blocks(self) -> Mapping[tuple[Table, int], BlockPart]:
        """Blocks by table and first address."""
        return {(block.table, block.address): block for block in self.of.parts.blocks.values()}

    @cached_property
    def _blank(self) -> frozenset[tuple[Table, int]]:
        """Registers that are nobody's, and read as 0."""
        parts = self.of.parts
        blank = {(table, at) for table, first, count in parts.reserved for at in range(first, first + count)}
        for block in parts.blocks.values():
            blank |= {(block.table, block.base + at) for at in range(block.registers)}
        return frozenset(blank - self.at.keys())

    def span(self, span: Span) -> Span:
        """The span itself, or that of the block that begins there. Raises Refused: a part of a block."""
        if (block := self.blocks.get((span.table, span.address))) is None:
            return span
        if span.count != block.registers:
            what = f"the block at {span.address} has {block.registers} registers, and is one; {span.count}"
            raise Refused(self.of.parts.manners.code("count"), f"{what} were asked for")
        return Span(span.table, block.base, span.count)

    def check(self, span: Span) -> None:
        """Check that all of a span is there. ``span``: of ``span``. Raises Refused."""
        if self.of.parts.manners.reads_gaps:
            return
        for address in range(span.address, span.address + span.count):
            if (span.table, address) not in self.at and (span.table, address) not in self._blank:
                where = f"{span.table.value.removesuffix('s')} {address & 0xFFFF}"
                raise Refused(self.of.parts.manners.code("address"), f"there is no {where}")

    @cached_property
    def cells(self) -> Sequence[Cell]:
        """Contents of a map: values, single bits, and words of bits."""
        tables, found = list(Table), []
        for (table, address), rows in self.at.items():
            first = rows[0]
            if first.place.bit is not None or first.place.mask is not None:
                found.append(self._word(table, address, rows))
            elif address == first.place.address:
                found.append(self._cell(first))
        starts = {block.number: block for block in self.of.parts.blocks.values()}
        shown = []
        for cell in found:
            number, at = divmod(cell.address, 0x10000)
            if number:
                name = next(each for each, block in self.of.parts.blocks.items() if block.number == number)
                about = f"block {name}, register {at}: {cell.about}"
                cell = Cell(
                    cell.table, starts[number].address, cell.type, cell.name, cell.unit, about,
                    cell.is_writable, cell.count,
                )  # fmt: skip
            shown.append(cell)
        return sorted(shown, key=lambda cell: (tables.index(cell.table), cell.address))

    def _cell(self, row: MapRow) -> Cell:
        place = row.place
        field = self.info.fields.get(row.name) if row.room == "parameter" else None
        unit = field.unit if field else "" if place.is_bit else _UNITS.get(row.name.rpartition("_")[2], "")
        if isinstance(row.part, CellPart):
            unit = row.part.unit
        elif place.conversion is not None:
            unit = place.conversion.shown
        if place.scale != 1:
            unit = f"{place.scale:g} {unit}".rstrip()
        about = field.meaning if field else row.about
        return Cell(place.table, place.address, place.type, row.name, unit, about, row.is_taken, place.count)

    @staticmethod
    def _word(table: Table, address: int, rows: Sequence[MapRow]) -> Cell:
        names = ", ".join(f"{_bits(row.place)} {row.name}" for row in rows)
        abouts = "; ".join(f"{row.name}: {row.about}" for row in rows if row.about)
        return Cell(table, address, "u16", f"bits {names}", "", abouts, any(row.is_taken for row in rows))

    @cached_property
    def crc(self) -> int:
        """CRC-32 of the map, with the order of words."""
        return crc_of(self.cells, self.version << 1 | self.of.is_low_first)


def _bits(place: RegisterPlace) -> str:
    return str(place.bit) if place.mask is None else f"{place.mask:04X}h"
