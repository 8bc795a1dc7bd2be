"""An RS485 wire with stations: half duplex, driver enable, collisions, and what can be wrong with it.

Pure: integer nanoseconds of simulated time come in as arguments. A burst, the bytes that a station sends in
one go, is the unit of work: one that nothing disturbs costs the same for two stations and for 252, because it
is decoded once and only those are told that it concerns.

Not modelled: the cable's length (no delay, no reflections), rise times, a receiver's threshold (``waveform``
says what contention reads as), parity and other character formats than eight data bits and one stop bit.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

from hil.vocab.faults import Fault
from hil.vocab.segment import Receiver, SegmentEvent
from hil.vocab.time import FOREVER, Clock, SimTimeNs
from hil.wire.byte_faults import ByteFault, ByteFaults
from hil.wire.packet import Malformed, Packet, PacketDecoder
from hil.wire.serial_line import character_ns
from virtual_ports.rs485.disturbed import DisturbedLine, Ear
from virtual_ports.rs485.packet_faults import Phantom, Transform, packet_fault
from virtual_ports.rs485.stats import SegmentStats, StationStats, fault_of
from virtual_ports.rs485.waveform import Character, Drive

BROADCAST = 0
MONITOR = ""
"""The name of the listener that the statistics come from."""
WINDOW_CHARACTERS = 64
"""How far ahead a disturbed line is read at a time, at the speed of its fastest sender."""
PIECE_BYTES = 256
"""Of what a disturbed line reads as, watchers get so many at least, or all there are when it ends."""


class Burst(NamedTuple):
    """What a station sends in one go; its driver is on from ``on_ns`` to ``off_ns``."""

    station: str
    start_ns: int
    data: bytes
    baud: int
    on_ns: int
    off_ns: int


class _Clean(NamedTuple):
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
    """Stations on one wire. Nobody senses the line before it sends: two that send at once collide.

    All that happens here happens at times of ``clock``, in their order: a burst begins, what disturbed it is
    told, it ends. Nothing else moves the line on, so whoever looks at it changes nothing.
    """

    def __init__(self, clock: Clock) -> None:
        self.stats = SegmentStats()
        self.stations: dict[str, Station] = {}
        self.watchers: list[Callable[[SegmentEvent], None]] = []
        self.noise: dict[int, ByteFaults] = {}
        """What the wire does to all bytes, by the numbers of faults."""
        self._busy: set[str] = set()
        """Stations whose firmware does not take bytes as they come: each counts for their buffers."""
        self._clock = clock
        self._by_address: dict[int | None, dict[str, Station]] = {None: {}}
        self._decoder = PacketDecoder()
        self._clean: list[_Clean] = []
        self._line: DisturbedLine | None = None
        """What is on the line, if it is disturbed."""
        self._told: dict[str, tuple[Character, ...]] = {}
        """What was read on it last, by stations."""
        self._told_ns: int = FOREVER
        """Receivers know what they hear up to then. What they knew of later was taken back."""
        self._tell_ns: int = FOREVER
        """When they are told more."""
        self._piece: list[int] = []
        """What it read as, and watchers were not shown yet."""
        self._piece_ns = 0
        self._piece_of: dict[str, None] = {}
        """Who has sent meanwhile."""
        self._monitor = Ear(MONITOR, 0)
        self._waiting: set[str] = set()
        """Stations that have a burst to send when the present one is out."""
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

    def set_polling(self, station: str, is_polling: bool) -> None:
        """Whether a station's firmware takes bytes as they come: else it hears what is for others too."""
        (self._busy.discard if is_polling else self._busy.add)(station)

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
        return self.stats.counters(elapsed_ns)

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
        """A station sends a burst, whose first start bit is at ``start_ns``: until then nothing happens."""
        if start_ns > self._clock.now_ns:
            self._clock.at(start_ns, partial(self._begin, station, data, baud))
        else:
            self._begin(station, data, baud, self._clock.now_ns)

    def _begin(self, station: str, data: bytes, baud: int, now_ns: SimTimeNs) -> None:
        self._settle(now_ns)
        sender = self.stations.get(station)
        if sender is None:  # it has left meanwhile
            return
        end_ns = self.stats.end_ns(station)
        if end_ns > now_ns:
            self._wait(station, end_ns, data, baud)
            return
        for transform in sender.transforms.values():
            data = transform(data)
        for noise in self.noise.values():
            data = b"".join(piece for _, piece in noise.apply(data))
        if not data:
            return
        end_ns = now_ns + character_ns(len(data), baud)
        burst = Burst(station, now_ns, data, baud, now_ns, end_ns + sender.release_ns)
        own = self.stats.stations[station]
        own.bursts += 1
        own.bytes += len(data)
        if sender.is_cut:
            return
        is_alone = self.stats.begin(station, len(data), now_ns, end_ns, burst.off_ns)
        if is_alone and not self._line and not self._is_odd:
            self._bring(burst)
        else:
            self._disturb(burst)
        self._clock.at(burst.off_ns, self._settle)

    def _wait(self, station: str, end_ns: int, data: bytes, baud: int) -> None:
        """A station that still sends is to send more, as by a fault. It has one UART, where one burst can
        wait; more is lost."""

        def begin(now_ns: SimTimeNs) -> None:
            self._waiting.discard(station)
            self._begin(station, data, baud, now_ns)

        if station not in self._waiting:
            self._waiting.add(station)
            self._clock.at(end_ns, begin)

    def _settle(self, now_ns: SimTimeNs) -> None:
        """Count, and tell watchers, what has been on the line to its end by now."""
        self.stats.settle(now_ns)
        while self._clean and self._clean[0].burst.off_ns <= now_ns:
            clean = self._clean.pop(0)
            self.stats.count(clean.items)
            wrong = dict.fromkeys(fault_of(item) for item in clean.items)
            about = " ".join([clean.burst.station, *filter(None, wrong)])
            self._show(clean.burst.start_ns, clean.burst.data, about)
        if self._line and self._line.off_ns <= now_ns:
            self._end(self._line, now_ns)

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
        for name in self._busy - told:
            if name in self.stations:
                yield self.stations[name]

    # ---- a disturbed line ----

    def _disturb(self, burst: Burst) -> None:
        """A burst that another overlaps, or on a line that is not right: from its start on everybody hears
        something else. They are told before the next character can be complete, and not sooner: of all that
        begins about then at once."""
        now_ns = SimTimeNs(burst.start_ns)
        was_clean = bool(self._clean)
        if not self._line:
            self._spoil(burst)
        self._drive(burst)
        if self._told_ns < self._tell_ns < FOREVER:
            return
        baud = 1
        for station in self.stations.values():
            if not station.is_cut:
                station.receiver.retract(now_ns)
                baud = max(baud, station.receiver.baud_now)
        told = {id(characters): characters for characters in self._told.values()}.values()
        under_way = [each.at_ns for characters in told for each in characters if each.at_ns > now_ns]
        next_ns = now_ns + 1 if was_clean else min([now_ns + character_ns(1, baud), *under_way])
        self._told_ns = now_ns
        self._tell_at(next_ns)

    def _spoil(self, burst: Burst) -> None:
        """What is on the line is not what it was taken for."""
        bursts = [clean.burst for clean in self._clean]
        if self._clean:
            self._decoder = self._clean[0].before
            self._clean.clear()
        first = bursts[0] if bursts else burst
        self._line = DisturbedLine(first.on_ns)
        self._told = {}
        self._piece_ns, self._piece_of = first.start_ns, {}
        self._monitor = Ear(MONITOR, 0)
        for each in bursts:
            self._drive(each)

    def _drive(self, burst: Burst) -> None:
        assert self._line
        is_swapped = burst.station in self.stations and self.stations[burst.station].is_swapped
        drive = Drive(burst.start_ns, burst.data, burst.baud, burst.on_ns, burst.off_ns, is_swapped)
        self._line.add(burst.station, drive)
        if burst.start_ns == self._line.from_ns:  # of several, the order in which they came does not matter
            self._monitor = Ear(MONITOR, max(self._monitor.baud, burst.baud))
        self._piece_of[burst.station] = None

    def _tell_at(self, at_ns: int) -> None:
        self._tell_ns = at_ns
        if at_ns < FOREVER:
            self._clock.at(at_ns, self._tell)

    def _tell(self, now_ns: SimTimeNs) -> None:
        if self._line and now_ns == self._tell_ns:
            until_ns = now_ns + character_ns(WINDOW_CHARACTERS, self._line.fastest_baud)
            self._read(self._line, now_ns, until_ns if until_ns < self._line.off_ns else FOREVER)
            if len(self._piece) >= PIECE_BYTES:
                self._show_piece(now_ns)

    def _read(self, line: DisturbedLine, now_ns: int, until_ns: int) -> None:
        """Tell receivers what they do not know yet and hear up to a time; keep what is decided of what the
        monitor does."""
        told_ns = self._told_ns
        members = [each for each in self.stations.values() if not each.is_cut and told_ns < FOREVER]
        ears = [Ear(each.name, each.receiver.baud_now, each.is_swapped, each.has_echo) for each in members]
        is_held = any(
            each.is_stuck and not each.is_swapped and not each.is_cut for each in self.stations.values()
        )
        heard = line.read([*ears, self._monitor], now_ns, until_ns, is_held=is_held)
        fresh: dict[int, tuple[Character, ...]] = {}
        for member in members:
            characters = heard[member.name]
            if id(characters) not in fresh:
                fresh[id(characters)] = tuple(each for each in characters if each.at_ns > told_ns)
            if news := fresh[id(characters)]:
                member.receiver.hear_characters(news)
        self._piece += [each.byte for each in heard[MONITOR] if each.at_ns <= now_ns]
        self._told, self._told_ns = heard, until_ns
        self._tell_at(until_ns)

    def _end(self, line: DisturbedLine, now_ns: int) -> None:
        """The last driver has let go: what is under way reads an idle line."""
        self._read(line, now_ns, FOREVER)
        self._piece += [each.byte for each in self._told[MONITOR] if each.at_ns > now_ns]
        self._show_piece(now_ns)
        self._line = None

    def _show_piece(self, now_ns: int) -> None:
        data = bytes(self._piece)
        self.stats.count(self._decoder.feed(data))
        senders = " and ".join(self._piece_of)
        about = (
            f"collision of {senders}" if len(self._piece_of) > 1 else f"{senders} on a line that is not right"
        )
        self._show(self._piece_ns, data, about, is_damaged=True)
        self._piece.clear()
        self._piece_ns, self._piece_of = now_ns, dict.fromkeys(self.stats.senders)


def poll_cycle_ns(nodes: int, command_bytes: int, baud: int, turnaround_characters: int = 2) -> int:
    """How long a master takes to send each node a command of so many data bytes and to get its ACK.

    Both packets (six bytes and the data, one byte in an ACK), a node's turnaround, the same for the master.
    """
    characters = (6 + command_bytes) + turnaround_characters + 7 + turnaround_characters
    return nodes * character_ns(characters, baud)
