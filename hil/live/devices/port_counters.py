"""Counters of a port, as the status of a device has them."""

from dataclasses import asdict
from typing import Any

from hil.vocab.ports import Port, PortStats

NO_PORT = PortStats(clients=0, connects=0, rx_bytes=0, tx_bytes=0, dropped_bytes=0, unheard_bytes=0)
_NO_COUNTERS = ("clients", "away", "echo")


def port_counters(stats: PortStats) -> dict[str, int]:
    return {name: count for name, count in asdict(stats).items() if name not in _NO_COUNTERS}


def port_row(port: Port) -> dict[str, Any]:
    """Address of a port, and the number of its clients."""
    return {"address": port.address, "clients": port.stats().clients}
