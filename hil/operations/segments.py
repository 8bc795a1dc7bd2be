"""Segments in the daemon's answers."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hil.daemon import Daemon


def listed(daemon: "Daemon") -> list[dict[str, Any]]:
    """Each segment with its stations and counters."""
    now_ns = daemon.bench.now_ns
    rows = []
    for name, segment in daemon.bench.segments.items():
        taps = [
            {"tap": label, "address": session.port.address, "clients": session.port.stats().clients}
            for label, session in daemon.places.taps().items()
            if label.startswith(f"{name}.")
        ]
        clashes = [f"address {address}: {', '.join(who)}" for address, who in segment.clashes().items()]
        notes = [f"two stations have one {clash}" for clash in clashes]
        for label, session in daemon.places.taps().items():
            if label.startswith(f"{name}."):
                notes += [session.failure] if session.failure else []
                notes += session.end.tap.notes.values()
        rows.append({"segment": name, "taps": taps, "notes": notes} | segment.counters(now_ns))
    return rows
