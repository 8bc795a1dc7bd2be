"""Plan of reads: which requests read the places of a drive's map, and what their answers mean."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from graphlib import TopologicalSorter

from bridges.modbus.protocol.pdu import Span, Table
from bridges.modbus.registers.drive_map import DriveMap, RegisterPlace
from bridges.modbus.registers.map_parts import CIA402, StatePart
from hil.drives.drive_link import Reading
from hil.vocab.drive_words import MORE_TOLD, TOLD

GAP_REGISTERS = 8
"""Maximum number of registers nobody wants between two that are read together: a request and its answer cost
13 characters and two silences more, a register two."""
MOST_REGISTERS, MOST_BITS = 125, 2000
"""Maximum of one read. Modbus Application Protocol V1.1b3, functions 01 to 04."""
_BITS = (Table.COILS, Table.DISCRETE_INPUTS)

Words = dict[Table, dict[int, int]]
"""Registers, or bits, by table and address."""


def spans_of(
    places: Iterable[RegisterPlace], gap: int = GAP_REGISTERS, most_registers: int = MOST_REGISTERS
) -> tuple[Span, ...]:
    """Reads that have all of these places, few and short. ``gap``: maximum of registers between two that are
    read with them; 0 for a drive that refuses registers that it has not; ``most_registers``: of one read."""
    wanted = sorted({(list(Table).index(place.table), place.address, place.width) for place in places})
    spans: list[Span] = []
    for index, address, width in wanted:
        table = list(Table)[index]
        most = MOST_BITS if table in _BITS else most_registers
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
        if of.version > 1:
            return cls(of, dict(_told_by(of)), {f"control.{name}": each for name, each in of.control.items()})
        kept = {name: place for name, place in of.values.items() if name in ("set_point_deg",)}
        kept |= {f"control.{name}": place for name, place in of.control.items()}
        told = {name: place for name, place in of.values.items() if name not in _WRITTEN}
        told |= {f"status.{name}": place for name, place in of.status.items()}
        return cls(of, told, kept)

    def state(self, *, gap: int, has_kept: bool) -> tuple[Span, ...]:
        """Reads of the state. ``has_kept``: the drive tells what was written to it, too."""
        places = [*self.told.values(), *(self.kept.values() if has_kept else ())]
        most = self.of.parts.manners.reads_most
        blocks = {place.address >> 16: place.table for place in places if place.address >> 16}
        spans = spans_of([place for place in places if not place.address >> 16], gap, most)
        known = {block.number: block for block in self.of.parts.blocks.values()}
        return (
            *spans,
            *(Span(table, known[number].base, known[number].registers) for number, table in blocks.items()),
        )

    def asked(self, span: Span) -> Span:
        """Span as it is asked for: of a block where it is in its table."""
        block = next((each for each in self.of.parts.blocks.values() if each.base == span.address), None)
        return span if block is None else Span(block.table, block.address, span.count)

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
            elif name.startswith(STATE):
                number = int(place.value(tuple(known), is_low_first=self.of.is_low_first))
                bits |= _state_bits(self.of.parts.states[name.removeprefix(STATE)][1], number)
            else:
                place = place.resolved(lambda cell: values.get(f"cells.{cell}", self._default(cell)))
                values[name] = place.value(tuple(known), is_low_first=self.of.is_low_first)
        if "velocity_rpm" not in values and (speed_rpm := values.get("speed_rpm")) is not None:
            values["velocity_rpm"] = -speed_rpm if bits.get("status.backward") else speed_rpm
        return Reading(at_ns, values, bits, words)

    def _default(self, cell: str) -> float:
        cells = self.of.parts.cells
        return cells[cell][1].default if cell in cells else 1.0


STATE, FIRST_MOVE = "states.", "move_0."


def _told_by(of: DriveMap) -> Iterator[tuple[str, RegisterPlace]]:
    """Places that tell something, by name: cells that are factors first, then states, values and bits."""
    for name in _factors(of):
        if of.parts.cells[name][1].is_read:
            yield f"cells.{name}", of.parts.cells[name][0]
    for name, (place, _) in of.parts.states.items():
        yield f"{STATE}{name}", place
    yield from ((name, place) for name, place in of.values.items() if name in TOLD or name in MORE_TOLD)
    yield from ((f"status.{name}", place) for name, place in of.status.items())


def _factors(of: DriveMap) -> Iterable[str]:
    """Cells by which values and moves are converted, each behind those by which it is converted itself."""
    cells = of.parts.cells
    graph: dict[str, tuple[str, ...]] = {}
    places = [*of.values.values(), *(place for _, place in of.parts.also)]
    places += [place for name, (place, _) in cells.items() if name.startswith(FIRST_MOVE)]
    for place in places:
        names = place.conversion.names if place.conversion else ()
        for name in names:
            if name in cells and name not in graph:
                own = cells[name][0].conversion
                graph[name] = tuple(each for each in own.names if each in cells) if own else ()
                places.append(cells[name][0])
    return TopologicalSorter(graph).static_order()


def _state_bits(part: StatePart, number: int) -> dict[str, bool]:
    """Bits of the status that a number of a state is."""
    if part.standard == CIA402:
        return {
            "status.enabled": number & 0x6F == 0x27,
            "status.fault": bool(number & 0x08),
            "status.moving": number & 0x6F == 0x27 and not number & 0x0400,
        }
    counts = Counter(each for _, each in part.numbers)
    known = {condition for condition, each in part.numbers if counts[each] == 1}
    held = {condition for condition, each in part.numbers if each == number and condition in known}
    bits = {
        f"status.{name}": name in held for name in ("enabled", "moving", "fault", "backward") if name in known
    }
    if "running" in known or "at_speed" in known or "standing" in known:
        bits["status.moving"] = bool(held & {"running", "at_speed", "moving"})
    return bits


_WRITTEN = ("set_point_deg", "set_velocity_rpm", "acceleration_rpm_per_s")
"""Values that are written and tell no state."""
