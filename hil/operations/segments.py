"""Segments in the answers."""

from typing import Any

from hil.live.places import Places
from hil.sim.bench import BenchRuntime


def listed(sim: BenchRuntime, places: Places) -> list[dict[str, Any]]:
    """Each segment with its stations, taps and counters."""
    now_ns = sim.now_ns
    rows = []
    for name, segment in sim.segments.items():
        own = {label: tap for label, tap in places.taps().items() if label.startswith(f"{name}.")}
        taps = [
            {"tap": label, "address": tap.port.address, "clients": tap.port.stats().clients}
            for label, tap in own.items()
        ]
        clashes = [f"address {address}: {', '.join(who)}" for address, who in segment.clashes().items()]
        notes = [f"two stations have one {clash}" for clash in clashes]
        for tap in own.values():
            notes += [tap.failure] if tap.failure else []
            notes += tap.end.tap.notes.values()
        rows.append({"segment": name, "taps": taps, "notes": notes} | segment.counters(now_ns))
    return rows
