"""Reports on the CAN buses of a bench."""

from typing import Any

from hil.config.station_names import CANOPEN, node_name
from hil.live.places import Places
from hil.sim.bench import BenchRuntime
from hil.vocab.address import owner_of
from hil.vocab.verbs import VerbRefused


def listed_buses(sim: BenchRuntime, places: Places) -> list[dict[str, Any]]:
    """List each bus with its taps, nodes, drives and counters. ``nodes``: all controllers on the bus, those
    of taps too; ``drives``: what the CANopen nodes are."""
    now_ns, rows = sim.now_ns, []
    for name, bus in sim.wires_of("can").items():
        own = {label: tap for label, tap in places.taps.items() if owner_of(label) == name}
        taps = [
            {"tap": label, "address": tap.port.address, "clients": tap.port.stats().clients}
            for label, tap in own.items()
        ]
        drives = {label: card.counters() for label, card in sim.cards_on(bus).items()}
        notes = []
        for label, tap in own.items():
            notes += [tap.failure] if tap.failure else []
            notes += [f"{label}: {note}" for note in tap.end.tap.notes.values()]
        rows.append(bus.counters(now_ns) | {"taps": taps, "drives": drives, "notes": notes})
    return rows


def data_sheet(sim: BenchRuntime, axis: str) -> dict[str, str]:
    """Answer the EDS of an axis's node. Raises VerbRefused: it has none."""
    name = node_name(axis, CANOPEN)
    cards = _cards(sim)
    if name not in cards:
        known = ", ".join(cards) or "none"
        raise VerbRefused("no_place", f"{axis} has no CANopen node; there are {known}")
    return {"node": name, "text": cards[name].eds()}


def listed_nodes(sim: BenchRuntime) -> list[dict[str, Any]]:
    """List the CANopen nodes with their buses."""
    cards = _cards(sim).items()
    return [{"node": name, "id": card.node_id, "bus": card.wire.name} for name, card in cards]


def _cards(sim: BenchRuntime) -> dict[str, Any]:
    return {name: card for bus in sim.wires_of("can").values() for name, card in sim.cards_on(bus).items()}
