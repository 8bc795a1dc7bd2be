"""Stations of a segment: the faults of each, and those whom a packet concerns."""

from collections.abc import Collection
from dataclasses import dataclass, field

from hil.vocab.faults import Fault
from hil.vocab.framing import Transform
from hil.vocab.line_format import LineFormat
from hil.vocab.segment import FormatReceiver, Receiver


@dataclass
class Station:
    """Transceiver on the wire, and its faults."""

    name: str
    receiver: Receiver
    address: int | None = None
    """Address whose packets, with those for everybody, are all that concerns it; None: everything does."""
    has_echo: bool = False
    """True if its receiver stays on while it drives."""
    release_ns: int = 0
    """Time that its driver stays on after the last stop bit."""
    is_stuck: bool = False
    """True if its driver is always on."""
    is_swapped: bool = False
    """True if its two wires are swapped."""
    is_cut: bool = False
    """True if the wire to it is cut, or it has left the line."""
    left_address: int | None = None
    """Address that it has left to another node: it is off the line until it has another one."""
    wire_faults: dict[int, Fault] = field(default_factory=dict)
    """Faults by number, the oldest first; the fields above follow from them and ``left_address``."""
    transforms: dict[int, Transform] = field(default_factory=dict)
    """Changes of its packets, by the numbers of faults."""

    @property
    def is_odd(self) -> bool:
        return (self.is_stuck or self.is_swapped) and not self.is_cut

    @property
    def format_now(self) -> LineFormat | None:
        """Format in which it reads; None: the line's."""
        return self.receiver.format_now if isinstance(self.receiver, FormatReceiver) else None

    def rewire(self) -> None:
        """Derive its wire from all its faults; of two late drivers the later fault's counts."""
        faults = self.wire_faults.values()
        kinds = {fault.kind for fault in faults}
        self.is_cut = self.left_address is not None or "wire_cut" in kinds
        self.is_swapped = "wire_swapped" in kinds
        self.is_stuck = "driver_stuck" in kinds
        late_us = [fault.number("late_us") for fault in faults if fault.kind == "driver_late"]
        self.release_ns = round(late_us[-1] * 1000) if late_us else 0


class Stations(dict[str, Station]):
    """Stations by name, and by address too."""

    def __init__(self) -> None:
        super().__init__()
        self.by_address: dict[int | None, dict[str, Station]] = {None: {}}
        self.busy: set[str] = set()
        """Stations whose firmware does not take bytes as they come: each counts for their buffers."""
        self.is_odd = False
        """True if a station has swapped wires or a driver that is always on."""

    def join(self, station: Station) -> None:
        self[station.name] = self.by_address[None][station.name] = station

    def leave(self, name: str) -> None:
        self.by_address[self.pop(name).address].pop(name)
        self.changed()

    def set_address(self, name: str, address: int | None) -> None:
        station = self[name]
        self.by_address[station.address].pop(name)
        station.address = address
        self.by_address.setdefault(address, {})[name] = station
        if station.left_address is not None and address not in (None, station.left_address):
            station.left_address = None
            self.rewire(name)

    def rewire(self, name: str) -> None:
        """Derive a station's wire from its faults again."""
        self[name].rewire()
        self.changed()

    def changed(self) -> None:
        self.is_odd = any(station.is_odd for station in self.values())

    def concerned(self, addresses: Collection[int] | None) -> Collection[Station]:
        """Stations that have to hear what is for these addresses (None: for everybody): those that have them,
        listeners to everything, and the busy."""
        if addresses is None:
            return self.values()
        told = dict(self.by_address[None])
        for address in addresses:
            told |= self.by_address.get(address, {})
        told |= {name: self[name] for name in self.busy if name in self}
        return told.values()
