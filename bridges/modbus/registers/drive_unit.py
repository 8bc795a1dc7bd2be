"""Unit of a drive with a map of its own: the same contract as ``RegisterUnit``.

It keeps nothing but the map: what a register has is the drive's, which tells it by the names of the map, and
what a client writes is a verb of the drive's, as one: ``set_point`` where there is a set-point in it, else
``write``. So every door and every node shows the same.
"""

from collections.abc import Mapping, Sequence
from math import hypot, isfinite

from bridges.modbus.protocol.pdu import Code, Refused, Span, Table, Write
from bridges.modbus.registers.cells import Halves, WrittenWords
from bridges.modbus.registers.drive_cells import DriveCells, MapEntry
from bridges.modbus.registers.drive_map import DriveMap, RegisterPlace
from bridges.modbus.registers.map_parts import USUAL
from bridges.modbus.registers.register_map import Wanted
from bridges.modbus.registers.register_unit import VerbStage
from hil.vocab.desk_protocol import AxisLook, DeviceInfo
from hil.vocab.packed_fields import value_at

SET_POINT = "set_point_deg"
_OF_REGISTERS = (Table.INPUT_REGISTERS, Table.HOLDING_REGISTERS)


class DriveUnit:
    """Unit of one drive, ``bridges.modbus.registers.registers_protocol.Registers``."""

    def __init__(self, of: DriveMap, info: DeviceInfo) -> None:
        self.map = DriveCells(of, info)
        self._is_low_first = of.is_low_first

    manners = USUAL
    looks_before_writes = False

    def needs_look(self, span: Span) -> bool:
        """True always: every register is the drive's."""
        return bool(self.map.info.fields)

    def read(self, span: Span, look: AxisLook | None, halves: Mapping[int, int]) -> Sequence[int]:
        """Read registers or bits, all of one moment. What the drive does not tell is 0.

        Raises:
            Refused: one of them is not there.
        """
        self.check(span)
        values = self._values(look) if look else {}
        elements = dict(halves) if span.table is Table.HOLDING_REGISTERS else {}
        addresses = range(span.address, span.address + span.count)
        for address in addresses:
            if address not in elements:
                elements = self._elements(span.table, address, values, look) | elements
        return [elements[address] for address in addresses]

    def check(self, span: Span) -> None:
        """Check that all of a span is there. Raises Refused."""
        self.map.check(span)

    def write(self, write: Write, halves: Halves, look: AxisLook | None = None) -> list[Wanted]:
        """Take registers or coils; answers what is to be done. A value of which a register is missing waits
        for it.

        Raises:
            Refused: nothing was taken.
        """
        self.check(Span(write.table, write.address, len(write.values)))
        given: dict[str, float] = {}
        fields: dict[str, float] = {}
        cleared: dict[str, float] = {}
        words = dict(enumerate(write.values, write.address))
        written = WrittenWords(words, halves)
        for entry in self._entries(write.table, words):
            place = entry.place
            if place.is_bit:
                given[entry.name] = words[place.address] >> (place.bit or 0) & 1
                if place.on_write and given[entry.name]:
                    cleared[entry.name] = 0
                continue
            addresses = range(place.address, place.address + place.width)
            if (own := written.whole(addresses)) is None:
                continue
            value = place.value(own, is_low_first=self._is_low_first)
            if not isfinite(value):
                raise Refused(Code.ILLEGAL_DATA_VALUE, f"{entry.name}: {value} is no number that can be used")
            (fields if entry.is_parameter else given)[entry.name] = value
        # From here on nothing is refused: what was written is taken.
        written.keep()
        name = "set_point" if SET_POINT in given else "write"
        wanted = [Wanted("do", {"name": name, "parameters": given})] if given else []
        wanted += [Wanted("do", {"name": "write", "parameters": cleared})] if cleared else []
        return [*wanted, *(Wanted("set", {"field": each, "value": fields[each]}) for each in fields)]

    def note(self, wanted: Wanted, stage: VerbStage) -> None:
        """Note nothing: the drive's own bits tell how it does."""

    def _entries(self, table: Table, words: Mapping[int, int]) -> list[MapEntry]:
        """Entries that a write has a part of, each once. Raises Refused: one of them is only told, or a bit
        means nothing."""
        found: dict[str, MapEntry] = {}
        for address, word in words.items():
            entries = self.map.at[table, address]
            where = f"{table.value.removesuffix('s')} {address}"
            if not any(entry.is_taken for entry in entries):
                raise Refused(Code.ILLEGAL_DATA_ADDRESS, f"{where}, {entries[0].name}, can only be read")
            known = sum(1 << (entry.place.bit or 0) for entry in entries if entry.place.is_bit)
            if entries[0].place.bit is not None and word & ~known:
                bit = (word & ~known).bit_length() - 1
                raise Refused(Code.ILLEGAL_DATA_VALUE, f"{where}: bit {bit} means nothing")
            for entry in entries:
                if entry.is_taken:
                    found[entry.name] = entry
        return list(found.values())

    def _elements(
        self, table: Table, address: int, values: Mapping[str, float], look: AxisLook | None
    ) -> dict[int, int]:
        """Bits or words, by their addresses, of what is at an address."""
        first, *others = self.map.at[table, address]
        place = first.place
        if place.is_bit:
            bits = ((values.get(each.name, 0) != 0) << (each.place.bit or 0) for each in (first, *others))
            return {address: sum(bits)}
        value = self._field(look, first.name) if first.is_parameter else values.get(first.name, 0.0)
        return dict(enumerate(self._words(place, value), place.address))

    def _words(self, place: RegisterPlace, value: float) -> tuple[int, ...]:
        finite = value if isfinite(value) else 0.0
        return place.words(finite, is_low_first=self._is_low_first)

    def _values(self, look: AxisLook) -> dict[str, float]:
        """Values and bits by name: of the axis, and what the drive tells itself, which counts more."""
        said, field = look.motion, self._field
        values = {
            "position_deg": said.position_deg,
            "set_point_deg": said.commanded_deg,
            "velocity_rpm": field(look, "velocity_rpm"),
            "current_A": hypot(field(look, "current_a_A"), field(look, "current_b_A")),
            "enabled": said.is_on,
            "moving": said.is_moving,
        }
        told = {name: 0.0 if value is None else value for name, value in values.items()} | dict(look.told)
        if look.failed is not None:
            told["fault"] = 1.0
        return told

    def _field(self, look: AxisLook | None, name: str) -> float:
        if look is None or (field := self.map.info.fields.get(name)) is None:
            return 0.0
        return value_at(look.packed, field.type, field.offset)
