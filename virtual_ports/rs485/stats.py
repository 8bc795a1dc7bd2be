"""Statistics of a segment."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from heapq import heappop, heappush
from typing import Any

from hil.vocab.framing import Item


@dataclass
class StationStats:
    """Counters of a station; ``collisions`` that happened while it sent."""

    bursts: int = 0
    bytes: int = 0
    collisions: int = 0


@dataclass(slots=True)
class _Sender:
    """Station whose driver is on."""

    collisions_before: int
    bursts: int = 0
    end_ns: int = 0


@dataclass
class SegmentStats:
    """Counters since the start; ``errors`` by what was wrong with what a listener made of the line."""

    packets: int = 0
    bytes: int = 0
    busy_ns: int = 0
    collisions: int = 0
    errors: dict[str, int] = field(default_factory=dict)
    stations: dict[str, StationStats] = field(default_factory=dict)
    senders: dict[str, _Sender] = field(default_factory=dict)
    """Stations whose driver is on now."""
    _ends: list[tuple[int, str]] = field(default_factory=list)
    """Heap of times at which drivers let go."""
    _free_ns: int = 0

    def begin(self, station: str, size: int, start_ns: int, end_ns: int, off_ns: int) -> bool:
        """Begin a burst; answers whether no other driver is on.

        A collision is a driver that comes on while another is on. One that has not let go since its last
        burst counts no second time: else the order of bursts that begin at one time would matter.
        """
        sender = self.senders.get(station)
        is_alone = len(self.senders) == (1 if sender else 0)
        if not sender:
            sender = self.senders[station] = _Sender(self.collisions)
            self.collisions += not is_alone
        sender.bursts += 1
        sender.end_ns = end_ns
        heappush(self._ends, (off_ns, station))
        self.bytes += size
        self.busy_ns += max(end_ns - max(start_ns, self._free_ns), 0)
        self._free_ns = max(self._free_ns, end_ns)
        return is_alone

    def end_ns(self, station: str) -> int:
        """Time at which the last bit of a station is out; its driver may stay on. 0: it is off."""
        sender = self.senders.get(station)
        return sender.end_ns if sender else 0

    def settle(self, now_ns: int) -> None:
        """Let go of the drivers that are off by now."""
        while self._ends and self._ends[0][0] <= now_ns:
            station = heappop(self._ends)[1]
            sender = self.senders[station]
            sender.bursts -= 1
            if not sender.bursts:
                self.stations[station].collisions += self.collisions - sender.collisions_before
                del self.senders[station]

    def count(self, items: Iterable[Item]) -> None:
        for item in items:
            self.packets += item.is_packet
            if fault := item.fault:
                self.errors[fault] = self.errors.get(fault, 0) + 1

    def load(self, elapsed_ns: int) -> float:
        """Share of the time in which somebody drove the line."""
        return self.busy_ns / elapsed_ns if elapsed_ns > 0 else 0.0

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        return {
            "load": self.load(elapsed_ns),
            "packets": self.packets,
            "bytes": self.bytes,
            "collisions": self.collisions,
            "errors": dict(self.errors),
            "stations": {name: self._of(name, each) for name, each in self.stations.items()},
        }

    def _of(self, name: str, station: StationStats) -> dict[str, int]:
        now = self.senders.get(name)
        so_far = self.collisions - now.collisions_before if now else 0
        return vars(station) | {"collisions": station.collisions + so_far}
