"""An RS485 wire with stations: half duplex, driver enable, collisions, and what can be wrong with it.

Pure: integer nanoseconds of simulated time come in as arguments. A burst, the bytes that a station sends in
one go, is the unit of work: one that nothing disturbs costs the same for two stations and for 252, because it
is decoded once and only those are told that it concerns.

Not modelled: the cable's length (no delay, no reflections), rise times, a receiver's threshold (``waveform``
says what contention reads as), parity and other character formats than eight data bits and one stop bit.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hil.vocab.faults import Fault
from hil.vocab.segment import HeardCharacter, Receiver, SegmentEvent
from hil.vocab.time import SimTimeNs
from hil.wire.byte_faults import ByteFault, ByteFaults
from hil.wire.packet import Malformed, Packet, PacketDecoder
from hil.wire.serial_line import character_ns
from virtual_ports.rs485.packet_faults import Phantom, Transform, packet_fault
from virtual_ports.rs485.waveform import Character, Drive, inverted, low_line, read

BROADCAST = 0
MONITOR = ""
"""The name of the listener that the statistics come from."""


@dataclass(frozen=True)
class Burst:
    """What a station sends in one go; its driver is on from ``on_ns`` to ``off_ns``."""

    station: str
    start_ns: int
    data: bytes
    baud: int
    on_ns: int
    off_ns: int

    @property
    def end_ns(self) -> int:
        return self.start_ns + character_ns(len(self.data), self.baud)


@dataclass
class StationStats:
    """What a station has sent."""

    bursts: int = 0
    bytes: int = 0
    collisions: int = 0


@dataclass
class SegmentStats:
    """Counters since the start; ``errors`` by what was wrong with what a listener made of the line."""

    packets: int = 0
    bytes: int = 0
    busy_ns: int = 0
    collisions: int = 0
    errors: dict[str, int] = field(default_factory=dict)
    stations: dict[str, StationStats] = field(default_factory=dict)

    def load(self, elapsed_ns: int) -> float:
        """Part of the time that somebody drove the line."""
        return self.busy_ns / elapsed_ns if elapsed_ns > 0 else 0.0


@dataclass(frozen=True)
class _Clean:
    """A burst that nothing has disturbed yet, and the decoder as it was before it."""

    burst: Burst
    items: list[Packet | Malformed]
    before: PacketDecoder


@dataclass
class Station:
    """A transceiver on the wire, and what is wrong with it."""

    name: str
    receiver: Receiver
    address: int | None = None
    """Only packets to it and to all concern it; None: everything does."""
    has_echo: bool = False
    """Its receiver stays on while it drives."""
    release_ns: int = 0
    """How long its driver stays on after the last stop bit."""
    is_stuck: bool = False
    """Its driver is always on."""
    is_swapped: bool = False
    """Its two wires are swapped."""
    is_cut: bool = False
    """The wire to it is cut, or it was taken off."""
    is_taken_off: bool = False
    wire_faults: dict[int, Fault] = field(default_factory=dict)
    """By their numbers, the oldest first; the fields above are what they and ``is_taken_off`` come to."""
    transforms: dict[int, Transform] = field(default_factory=dict)
    """What it sends instead of its packets, by the numbers of faults."""

    @property
    def is_odd(self) -> bool:
        return (self.is_stuck or self.is_swapped) and not self.is_cut


class Segment:
    """Stations on one wire. Nobody senses the line before it sends: two that send at once collide."""

    def __init__(self) -> None:
        self.stats = SegmentStats()
        self.stations: dict[str, Station] = {}
        self.watchers: list[Callable[[SegmentEvent], None]] = []
        self.noise: dict[int, ByteFaults] = {}
        """What the wire does to all bytes, by the numbers of faults."""
        self.busy: set[str] = set()
        """Stations whose firmware does not take bytes as they come: each counts for their buffers."""
        self._by_address: dict[int | None, dict[str, Station]] = {None: {}}
        self._decoder = PacketDecoder()
        self._clean: list[_Clean] = []
        self._cluster: list[Burst] = []
        self._is_odd = False

    # ---- stations ----

    def join(self, station: str, receiver: Receiver) -> None:
        """Put a station on the wire."""
        self.stations[station] = Station(station, receiver)
        self._by_address[None][station] = self.stations[station]
        self.stats.stations[station] = StationStats()

    def leave(self, station: str) -> None:
        """Take a station off; what it has sent goes on."""
        self._by_address[self.stations.pop(station).address].pop(station)
        self.changed()

    def set_address(self, station: str, address: int | None) -> None:
        """From now on only packets to this address and to all concern the station."""
        member = self.stations[station]
        self._by_address[member.address].pop(station)
        member.address = address
        self._by_address.setdefault(address, {})[station] = member

    def set_echo(self, station: str, has_echo: bool) -> None:
        """Whether a station's receiver stays on while it drives."""
        self.stations[station].has_echo = has_echo

    def has(self, station: str) -> bool:
        """Whether a station is on the wire."""
        return station in self.stations

    def baud_of(self, station: str) -> int:
        """The speed of a station, in baud."""
        return self.stations[station].receiver.baud_now

    def set_cut(self, station: str, is_cut: bool) -> None:
        """Take a station off the line, or put it back."""
        self.stations[station].is_taken_off = is_cut
        self._set_wire(self.stations[station])

    def clashes_with(self, address: int, but: str) -> list[str]:
        """Stations on the line, but one, that have an address."""
        members = self._by_address.get(address, {})
        return [name for name, member in members.items() if name != but and not member.is_cut]

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        """Statistics since the start, for JSON."""
        return {
            "load": self.stats.load(elapsed_ns),
            "packets": self.stats.packets,
            "bytes": self.stats.bytes,
            "collisions": self.stats.collisions,
            "errors": dict(self.stats.errors),
            "stations": {name: vars(each).copy() for name, each in self.stats.stations.items()},
        }

    # ---- faults (hil.vocab.faults) ----

    def inject(
        self, number: int, fault: Fault, station: str, answer: Callable[[int, str, bytes], None]
    ) -> None:
        """A fault of the layers packet or wire, or ``node_clash``, begins. ``answer(at_ns, station, raw)``
        sends for a station at a later time."""
        if fault.kind == "wire_noise":
            self.noise[number] = ByteFaults(
                ByteFault(bit_error_rate=fault.number("rate")), int(fault.number("seed"))
            )
        elif fault.kind == "node_clash":
            name = f"fault {number}"
            address = int(fault.number("address"))
            baud = next(iter(self.stations.values())).receiver.baud_now
            self.join(name, Phantom(address, baud, lambda at_ns, raw: answer(at_ns, name, raw)))
            self.set_address(name, address)
        elif fault.kind.startswith("packet_"):
            transform = packet_fault(fault.kind, fault.number("rate"), int(fault.number("seed")))
            self.stations[station].transforms[number] = transform
        else:
            self.stations[station].wire_faults[number] = fault
            self._set_wire(self.stations[station])

    def clear(self, number: int, fault: Fault, station: str) -> None:
        """A fault ends."""
        self.noise.pop(number, None)
        if fault.kind == "node_clash":
            self.leave(f"fault {number}")
        elif fault.layer == "wire" and fault.kind != "wire_noise":
            del self.stations[station].wire_faults[number]
            self._set_wire(self.stations[station])
        elif station in self.stations:
            self.stations[station].transforms.pop(number, None)

    def _set_wire(self, station: Station) -> None:
        """A station's wire is what all that is wrong with it says; of two late drivers the later fault's."""
        faults = station.wire_faults.values()
        kinds = {fault.kind for fault in faults}
        station.is_cut = station.is_taken_off or "wire_cut" in kinds
        station.is_swapped = "wire_swapped" in kinds
        station.is_stuck = "driver_stuck" in kinds
        late_us = [fault.number("late_us") for fault in faults if fault.kind == "driver_late"]
        station.release_ns = round(late_us[-1] * 1000) if late_us else 0
        self.changed()

    def changed(self) -> None:
        """Something about a station that can be wrong has changed."""
        self._is_odd = any(station.is_odd for station in self.stations.values())

    def clashes(self) -> Mapping[int, list[str]]:
        """Addresses that several stations have."""
        return {
            address: list(members)
            for address, members in self._by_address.items()
            if address is not None and len(members) > 1
        }

    # ---- the wire ----

    def transmit(self, station: str, start_ns: SimTimeNs, data: bytes, baud: int) -> None:
        """A station sends a burst; its first start bit is at ``start_ns``, now or later."""
        self.settle(start_ns)
        sender = self.stations[station]
        for transform in sender.transforms.values():
            data = transform(data)
        for noise in self.noise.values():
            data = b"".join(piece for _, piece in noise.apply(data))
        if not data:
            return
        end_ns = start_ns + character_ns(len(data), baud)
        burst = Burst(station, start_ns, data, baud, start_ns, end_ns + sender.release_ns)
        own = self.stats.stations[station]
        own.bursts += 1
        own.bytes += len(data)
        if sender.is_cut:
            return
        self.stats.bytes += len(data)
        on_line = [clean.burst for clean in self._clean] + self._cluster
        self.stats.busy_ns += max(end_ns - max([start_ns, *(each.end_ns for each in on_line)]), 0)
        overlaps = [each for each in on_line if each.station != station and each.off_ns > start_ns]
        if overlaps:
            self.stats.collisions += 1
            for name in {station, *(each.station for each in overlaps)}:
                self.stats.stations[name].collisions += 1
        if overlaps or self._cluster or self._is_odd:
            self._spoil()
            self._cluster.append(burst)
            self._tell_all(start_ns)
        else:
            self._bring(burst)

    def settle(self, until_ns: int) -> None:
        """Count, and tell listeners, what has been on the line to its end by ``until_ns``."""
        while self._clean and self._clean[0].burst.off_ns <= until_ns:
            clean = self._clean.pop(0)
            self._count(clean.items)
            wrong = dict.fromkeys(_fault(item) for item in clean.items)
            about = " ".join([clean.burst.station, *filter(None, wrong)])
            self._show(clean.burst.start_ns, clean.burst.data, about)
        if self._cluster and all(burst.off_ns <= until_ns for burst in self._cluster):
            heard = self._heard_by(Station(MONITOR, NOBODY))
            self._count(self._decoder.feed(bytes(each.byte for each in heard)))
            senders = " and ".join(dict.fromkeys(burst.station for burst in self._cluster))
            about = (
                f"collision of {senders}" if " and " in senders else f"{senders} on a line that is not right"
            )
            start_ns = min(burst.start_ns for burst in self._cluster)
            self._show(start_ns, bytes(each.byte for each in heard), about, is_damaged=True)
            self._cluster = []

    def _show(self, at_ns: int, data: bytes, about: str, *, is_damaged: bool = False) -> None:
        for watcher in self.watchers:
            watcher(SegmentEvent(SimTimeNs(at_ns), data, about, is_damaged))

    def _bring(self, burst: Burst) -> None:
        """A burst that nothing disturbs, so far."""
        before = self._decoder.copy()
        items = self._decoder.feed(burst.data)
        self._clean.append(_Clean(burst, items, before))
        if not before.pending and not self._decoder.pending:
            receivers = self._concerned(items)
        else:  # a piece of a packet: everybody's receiver has it
            receivers = iter(self.stations.values())
        for station in receivers:
            if not station.is_cut and (station.name != burst.station or station.has_echo):
                station.receiver.hear(SimTimeNs(burst.start_ns), burst.data, burst.baud)

    def _spoil(self) -> None:
        """What is on the line is not what it was taken for."""
        if self._clean:
            self._decoder = self._clean[0].before
            self._cluster += [clean.burst for clean in self._clean]
            self._clean.clear()

    def _concerned(self, items: list[Packet | Malformed]) -> Iterator[Station]:
        told: set[str] = set()
        addresses: dict[int | None, None] = {None: None}
        for item in items:
            if isinstance(item, Packet):
                if item.destination == BROADCAST:
                    yield from self.stations.values()
                    return
                addresses[item.destination] = None
        for address in addresses:
            for name, station in self._by_address.get(address, {}).items():
                told.add(name)
                yield station
        for name in self.busy - told:
            if name in self.stations:
                yield self.stations[name]

    def _count(self, items: list[Packet | Malformed]) -> None:
        for item in items:
            self.stats.packets += isinstance(item, Packet)
            if fault := _fault(item):
                self.stats.errors[fault] = self.stats.errors.get(fault, 0) + 1

    def _tell_all(self, now_ns: int) -> None:
        """From ``now_ns`` on everybody's receiver reads the line anew."""
        shared: dict[tuple[bool, int], tuple[Character, ...]] = {}
        senders = {burst.station for burst in self._cluster}
        for station in self.stations.values():
            if station.is_cut:
                continue
            station.receiver.retract(SimTimeNs(now_ns))
            if station.name in senders and not station.has_echo:
                heard = self._heard_after(now_ns, station)
            else:
                key = (station.is_swapped, station.receiver.baud_now)
                if key not in shared:
                    shared[key] = self._heard_after(now_ns, station)
                heard = shared[key]
            station.receiver.hear_characters(heard)

    def _heard_after(self, now_ns: int, listener: Station) -> tuple[Character, ...]:
        return tuple(each for each in self._heard_by(listener) if each.at_ns > now_ns)

    def _heard_by(self, listener: Station) -> list[Character]:
        from_ns = min(burst.on_ns for burst in self._cluster)
        to_ns = max(burst.off_ns for burst in self._cluster)
        drives = [
            Drive(b.start_ns, b.data, b.baud, b.on_ns, b.off_ns, self._is_swapped(b.station))
            for b in self._cluster
        ]
        drives += [
            Drive(from_ns, b"", 1, from_ns, to_ns, station.is_swapped)
            for station in self.stations.values()
            if station.is_stuck and not station.is_cut
        ]
        lows = low_line(drives)
        if listener.is_swapped:
            lows = inverted(lows, from_ns, to_ns)
        if not listener.has_echo:
            for burst in self._cluster:
                if burst.station == listener.name:
                    lows = _without(lows, burst.on_ns, burst.off_ns)
        return list(read(lows, listener.receiver.baud_now))

    def _is_swapped(self, name: str) -> bool:
        return name in self.stations and self.stations[name].is_swapped


def _fault(item: Packet | Malformed) -> str:
    """What is wrong with it, "" for nothing."""
    if isinstance(item, Malformed):
        return item.fault
    return "" if item.is_good else "CRC"


class _Nobody:
    """Where nothing is kept."""

    baud_now = 38400

    def hear(self, start_ns: SimTimeNs, data: bytes, baud: int) -> None:
        return

    def hear_characters(self, characters: Sequence[HeardCharacter]) -> None:
        return

    def retract(self, after_ns: SimTimeNs) -> None:
        return


NOBODY = _Nobody()


def _without(lows: list[tuple[int, int]], from_ns: int, to_ns: int) -> list[tuple[int, int]]:
    """The line as a receiver sees it that is off between two times."""
    kept = []
    for low_ns, high_ns in lows:
        if low_ns < from_ns:
            kept.append((low_ns, min(high_ns, from_ns)))
        if high_ns > to_ns:
            kept.append((max(low_ns, to_ns), high_ns))
    return kept


def poll_cycle_ns(nodes: int, command_bytes: int, baud: int, turnaround_characters: int = 2) -> int:
    """How long a master takes to send each node a command of so many data bytes and to get its ACK.

    Both packets (six bytes and the data, one byte in an ACK), a node's turnaround, the same for the master.
    """
    characters = (6 + command_bytes) + turnaround_characters + 7 + turnaround_characters
    return nodes * character_ns(characters, baud)
