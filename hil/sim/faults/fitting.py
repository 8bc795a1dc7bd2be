"""Places of a bench where faults can be, and which kinds fit each: for those who choose the place first."""

from collections.abc import Iterator
from typing import NamedTuple

from hil.sim.bench_parts import BenchParts, FaultPlace
from hil.vocab.address import owner_of
from hil.vocab.faults import FAULT_KINDS, Fault


class PlaceKinds(NamedTuple):
    """Place, and what can fail there."""

    place: str
    sort: str
    """device, port, axis, switch, node, tap or wire."""
    of: str
    """Device that it is a part of, or the wire of a tap; empty: it stands alone."""
    wire: str
    """Wire that it is on; empty: on none."""
    kinds: tuple[str, ...]


def fault_places(parts: BenchParts) -> Iterator[PlaceKinds]:
    """Find all places that a fault fits, in the bench's order."""
    wires = {id(wire): name for name, wire in parts.wires.items()}
    for target in parts.targets():
        place = parts.place(target)
        if place and (kinds := tuple(_kinds(target, place))):
            of = "" if target in parts.wires else owner_of(target)
            wire = wires.get(id(place.wire), "")
            sort = "switch" if place.switch else _sort(parts, target)
            yield PlaceKinds(target, sort, "" if of == target else of, wire, kinds)


def _kinds(target: str, place: FaultPlace) -> Iterator[str]:
    for kind in FAULT_KINDS.values():
        if place.fits(kind.target):
            of_wire = place.wire if place.is_wires(kind.target) else None
            if not (of_wire and of_wire.fault_problem(Fault(kind.name, target), ())):
                yield kind.name


def _sort(parts: BenchParts, target: str) -> str:
    if target in parts.wires:
        return "wire"
    if target in parts.taps:
        return "tap"
    if target in parts.cards:
        return "node"
    if target in parts.devices:
        return "device"
    return "axis" if target in parts.axes else "port"
