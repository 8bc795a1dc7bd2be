"""A CAN bus of a bench, with its faults."""

from typing import Any, NamedTuple

from bridges.can.bus.can_bus_protocol import CanBus, CanFaults


class BenchBus(NamedTuple):
    """Bus under its name, and what can go wrong on it."""

    name: str
    bus: CanBus
    faults: CanFaults

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        """Statistics since the start, for JSON."""
        return {"bus": self.name, "bit_rate": self.bus.bit_rate, **self.bus.counters(elapsed_ns)}
