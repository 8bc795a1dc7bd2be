"""Reports on the wires of a bench, as each describes itself, and on the cards of axes that are on them."""

from collections.abc import Iterator, Mapping
from typing import Any

from hil.config.station_names import CANOPEN, node_name
from hil.live.places import Places
from hil.sim.bench import BenchRuntime
from hil.sim.card import NumberedCard
from hil.vocab.health_words import HealthProblem
from hil.vocab.verbs import VerbRefused
from hil.vocab.wire import Report, Wire, WireTap


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
        known = ", ".join(cards) or "none"
        raise VerbRefused("no_place", f"{axis} has no CANopen node; there are {known}")
    return {"node": name, "text": cards[name].eds()}


def listed_nodes(sim: BenchRuntime) -> list[dict[str, Any]]:
    """List the CANopen nodes with their buses."""
    cards = _numbered(sim).items()
    return [{"node": name, "id": card.node_id, "bus": card.wire.name} for name, card in cards]


def _numbered(sim: BenchRuntime) -> Mapping[str, NumberedCard]:
    return {name: card for name, card in sim.cards.items() if isinstance(card, NumberedCard)}
