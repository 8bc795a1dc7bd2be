"""Benches with CAN buses, and lines of slcan."""

from typing import Any

M1 = {"profile": "mechaduino", "flash": {"table": "identity"}}
TAP = "can0.a"


def config(nodes: dict[str, Any] | None = None, *, taps: str = "a", **bus: Any) -> dict[str, Any]:
    """Bench of Mechaduinos with nodes on ``can0``, and taps of one letter each."""
    nodes = {"m1": 5} if nodes is None else nodes
    devices = {name: M1 for name in nodes} or {"m1": M1}
    wire = {"bit_rate": 500_000, "nodes": nodes, "taps": {tap: {"port": "memory"} for tap in taps}} | bus
    return {"bench": "t", "devices": devices, "can": {"can0": wire}}
