"""Reports on the wires of a bench, as each describes itself, on cards that are on them, and on echoes."""

from collections.abc import Iterator, Mapping
from typing import Any

from hil.config.station_names import CANOPEN, node_name
from hil.live.places import Places
from hil.sim.bench import BenchRuntime
from hil.sim.card import NumberedCard
from hil.sim.input_check import ADD_CAN
from hil.vocab.address import owner_of
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.device import Device
from hil.vocab.monitoring import HealthProblem
from hil.vocab.ports import EchoState
from hil.vocab.verbs import VerbRefused
from hil.vocab.wire import Report, Wire, WireTap

Echo = Mapping[str, str | int]
"""``hil.vocab.ports.EchoStats`` for JSON."""


def echoes(
    devices: Mapping[str, Device], sim: BenchRuntime, places: Places, bridges: Mapping[str, Bridge]
) -> Iterator[tuple[str, Echo] | None]:
    """Adapters, by the name of their place, or the address of a bridge's line; and None where others may have
    their turn."""
    told = [(link.label, link.port.stats().echo) for wire in sim.wires for link in places.of(wire)]
    for device in list(devices):
        if device in devices:  # a reload may have removed it meanwhile
            told += devices[device].echoes()
            yield None
    for name, echo in told:
        if echo and echo.state is not EchoState.UNSOUGHT:
            yield name, echo.as_dict()
    for bridge in bridges.values():
        for address, line in bridge.status().get("lines", {}).items():
            if "echo" in line:
                yield address, line["echo"]


def listed_wires(sim: BenchRuntime, places: Places, kind: str) -> list[Report]:
    """List each wire of a kind with its stations, taps, cards and counters."""
    now_ns, wires = sim.now_ns, sim.wires_of(kind).values()
    return [wire.report(now_ns, _taps(places, wire), sim.cards_on(wire)) for wire in wires]


def wire_problems(sim: BenchRuntime, places: Places) -> Iterator[HealthProblem]:
    """Present problems of all wires."""
    for wire in sim.wires.values():
        yield from wire.problems(_taps(places, wire))


def _taps(places: Places, wire: Wire) -> list[WireTap]:
    return [
        WireTap(each.label, each.port.address, each.port.stats().clients, each.failure, each.backend.tap)
        for each in places.of(wire.name)
    ]


def data_sheet(sim: BenchRuntime, axis: str) -> dict[str, str]:
    """Answer the EDS of an axis's node. Raises VerbRefused: it has none."""
    name, cards = node_name(axis, CANOPEN), _numbered(sim)
    if name not in cards:
        there = f"there are {', '.join(cards)}" if cards else f"this bench has none; {ADD_CAN}"
        raise VerbRefused("no_place", f"{axis} has no CANopen node; {there}")
    return {"node": name, "text": cards[name].eds()}


def listed_nodes(sim: BenchRuntime) -> list[dict[str, Any]]:
    """List the nodes that have a number: of CANopen, and stations of segments by their present addresses."""
    cards = _numbered(sim).items()
    stations = [
        {"node": name, "id": address, "bus": bus}
        for bus, segment in sim.segments.items()
        for name, address in segment.addresses().items()
        if owner_of(name) in sim.devices
    ]
    return [{"node": name, "id": card.node_id, "bus": card.wire.name} for name, card in cards] + stations


def _numbered(sim: BenchRuntime) -> Mapping[str, NumberedCard]:
    return {name: card for name, card in sim.cards.items() if isinstance(card, NumberedCard)}
