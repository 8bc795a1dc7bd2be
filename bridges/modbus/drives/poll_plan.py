"""Plan of reads: which requests read the places of a drive's map, and what their answers mean."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from bridges.modbus.protocol.pdu import Span, Table
from bridges.modbus.registers.drive_map import DriveMap, RegisterPlace
from hil.drives.drive_link import Reading

GAP_REGISTERS = 8
"""Maximum number of registers nobody wants between two that are read together: a request and its answer cost
13 characters and two silences more, a register two."""
MOST_REGISTERS, MOST_BITS = 125, 2000
"""Maximum of one read. Modbus Application Protocol V1.1b3, functions 01 to 04."""
_BITS = (Table.COILS, Table.DISCRETE_INPUTS)

Words = dict[Table, dict[int, int]]
"""Registers, or bits, by table and address."""


def spans_of(places: Iterable[RegisterPlace], gap: int = GAP_REGISTERS) -> tuple[Span, ...]:
    """Reads that have all of these places, few and short. ``gap``: maximum of registers between two that are
    read with them; 0 for a drive that refuses registers that it has not."""
    wanted = sorted({(list(Table).index(place.table), place.address, place.width) for place in places})
    spans: list[Span] = []
    for index, address, width in wanted:
        table = list(Table)[index]
        most = MOST_BITS if table in _BITS else MOST_REGISTERS
        last = spans[-1] if spans else None
        if last and last.table is table and address <= last.address + last.count + gap:
            count = max(last.count, address + width - last.address)
            if count <= most:
                spans[-1] = Span(table, last.address, count)
                continue
        spans.append(Span(table, address, width))
    return tuple(spans)


@dataclass(frozen=True)
class PollPlan:
    """Reads of one drive. ``state``: what is asked for each time; ``settings``: parameters, seldom; the
    second of each pair has no gaps. ``told``: places by name; ``kept``: those of what the daemon writes,
    which not every drive lets be read."""

    of: DriveMap
    told: Mapping[str, RegisterPlace]
    kept: Mapping[str, RegisterPlace]

    @classmethod
    def of_map(cls, of: DriveMap) -> "PollPlan":
        kept = {name: place for name, place in of.values.items() if name in ("set_point_deg",)}
        kept |= {f"control.{name}": place for name, place in of.control.items()}
        told = {name: place for name, place in of.values.items() if name not in _WRITTEN}
        told |= {f"status.{name}": place for name, place in of.status.items()}
        return cls(of, told, kept)

    def state(self, *, gap: int, has_kept: bool) -> tuple[Span, ...]:
        """Reads of the state. ``has_kept``: the drive tells what was written to it, too."""
        return spans_of([*self.told.values(), *(self.kept.values() if has_kept else ())], gap)

    def settings(self, *, gap: int) -> tuple[Span, ...]:
        """Reads of the parameters."""
        return spans_of(self.of.parameters.values(), gap)

    def reading(self, at_ns: int, words: Words) -> Reading:
        """Reading of words that were read; what is not among them is left out."""
        places = {**self.told, **self.kept, **self.of.parameters}
        values: dict[str, float] = {}
        bits: dict[str, bool] = {}
        for name, place in places.items():
            own = words.get(place.table, {})
            found = [own.get(place.address + offset) for offset in range(place.width)]
            known = [word for word in found if word is not None]
            if len(known) < place.width:
                continue
            if place.is_bit:
                bits[name] = bool(known[0] >> (place.bit or 0) & 1)
            else:
                values[name] = place.value(tuple(known), is_low_first=self.of.is_low_first)
        return Reading(at_ns, values, bits, words)


_WRITTEN = ("set_point_deg", "set_velocity_rpm", "acceleration_rpm_per_s")
"""Values that are written and tell no state."""
