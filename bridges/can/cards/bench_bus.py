"""A CAN bus of a bench, with its faults: a ``Wire`` of ``hil.vocab.wire``."""

from collections.abc import Callable, Collection, Iterable
from typing import Any

from bridges.can.bus.bus_events import BusEvent
from bridges.can.bus.can_bus import CanBus
from bridges.can.bus.can_faults import CanFaults
from bridges.can.cards.channel_node import MOST_NODES, ChannelNode
from hil.sim.client_tap import ClientTap
from hil.vocab.address import owner_of
from hil.vocab.faults import CAN_NODE, LINE, MOST_NOISES, ON_LINE, Fault
from hil.vocab.time import Clock


class BenchBus:
    """Bus under its name, and what can go wrong on it; without nodes at first. ``clock`` is the time in which
    things happen on it."""

    kind = "can"

    def __init__(self, name: str, clock: Clock, bit_rate: int) -> None:
        self.name = name
        self.bus = CanBus(clock, bit_rate)
        self.watchers: list[Callable[[BusEvent], None]] = self.bus.watchers
        self._faults = CanFaults(self.bus)

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        """Statistics since the start, for JSON."""
        return {"bus": self.name, "bit_rate": self.bus.bit_rate, **self.bus.counters(elapsed_ns)}

    def fault_targets(self, station: str) -> Collection[str]:
        return (ON_LINE, CAN_NODE) if station else (LINE,)

    def fault_problem(self, fault: Fault, active: Iterable[Fault]) -> str | None:
        noises = [each for each in active if (each.kind, each.target) == ("wire_noise", self.name)]
        if fault.kind == "wire_noise" and len(noises) >= MOST_NOISES:
            return f"{self.name} has {MOST_NOISES} noises already; clear one of them"
        return None

    def inject(self, number: int, fault: Fault, station: str) -> None:
        self._faults.inject(number, fault, station)

    def clear(self, number: int, fault: Fault, station: str) -> None:
        self._faults.clear(number, fault, station)

    # ---- hil.sim.channels.HasChannels ----

    def channel(self, label: str) -> ChannelNode:
        return ChannelNode(label, self.bus)

    def channel_problem(self, label: str, taps: Iterable[ClientTap]) -> str | None:
        channels = {tap.name: tap for tap in taps if isinstance(tap, ChannelNode)}
        if label in self.bus.nodes:
            return None if label in channels else f"{label} is a node of another kind"
        here = [name for name in channels if owner_of(name) == self.name]
        return f"{self.name} has {MOST_NODES} channels already" if len(here) >= MOST_NODES else None
