"""A wire alone on a clock of its own, what its receivers were told, and a slow wire to compare with."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from typing import Any, NamedTuple

from device_profiles.sac.framing import FRAMING
from device_profiles.sac.packet import PacketDecoder
from hil.vocab.framing import Framing
from hil.wire.serial_line import resample
from virtual_ports.rs485.segment import Rs485Segment
from virtual_ports.rs485.stations import Station

BAUD = 38400


def characters_ns(count: int, baud: int = BAUD) -> int:
    return count * 10 * 10**9 // baud


class Timeline:
    """Simulated time, as a group has it."""

    def __init__(self) -> None:
        self.now_ns: Any = 0
        self._calls: list[tuple[int, int, Callable[[Any], None]]] = []
        self._count = 0

    def at(self, at_ns: int, call: Callable[[Any], None]) -> None:
        self._count += 1
        heappush(self._calls, (at_ns, self._count, call))

    def run(self, until_ns: int) -> None:
        while self._calls and self._calls[0][0] <= until_ns:
            self.now_ns, _, call = heappop(self._calls)
            call(self.now_ns)
        self.now_ns = max(self.now_ns, until_ns)


@dataclass
class Ear:
    """A receiver that keeps what it is told, as a UART does. It is told in time, and what has come stays."""

    clock: Timeline
    baud_now: int = BAUD
    got: list[tuple[int, int]] = field(default_factory=list)
    told: int = 0

    def hear(self, start_ns: int, data: bytes, baud: int, packets: object = None) -> None:
        self.told += 1
        if baud == self.baud_now:
            self.got += [(start_ns + characters_ns(i + 1, baud), byte) for i, byte in enumerate(data)]
        else:
            one_ns = characters_ns(1, self.baud_now)
            sampled = resample(data, baud, self.baud_now)
            self.got += [(start_ns + each.offset_ns + one_ns, each.byte) for each in sampled]

    def hear_characters(self, characters: Sequence[Any]) -> None:
        self.told += 1
        assert all(each.at_ns >= self.clock.now_ns for each in characters), "told when it was over"
        self.got += [(each.at_ns, each.byte) for each in characters]

    def retract(self, after_ns: int) -> None:
        assert after_ns >= self.clock.now_ns, "what has come cannot be taken back"
        self.got = [each for each in self.got if each[0] <= after_ns]

    @property
    def data(self) -> bytes:
        return bytes(byte for _, byte in self.got)


class Wire(Rs485Segment):
    """Stations by their names, or by their names and bauds."""

    def __init__(self, *names: str, bauds: Iterable[int] = (), framing: Framing = FRAMING) -> None:
        self.clock = Timeline()
        super().__init__(self.clock, framing)
        self.ears = {name: Ear(self.clock) for name in names}
        for ear, baud in zip(self.ears.values(), bauds, strict=False):
            ear.baud_now = baud
        for name, ear in self.ears.items():
            self.join(name, ear)

    def send(self, station: str, at_ns: int, data: bytes) -> None:
        """At that time, and not before."""
        self.clock.run(at_ns)
        self.transmit(station, self.clock.now_ns, data, self.ears[station].baud_now)

    def heard(self) -> dict[str, bytes]:
        """By all stations, when everything is over."""
        self.clock.run(self.clock.now_ns + 10**8)
        return {name: ear.data for name, ear in self.ears.items()}


# ---- slow and simple ----


class Sent(NamedTuple):
    """A burst."""

    start_ns: int
    station: str
    data: bytes


class SlowWire:
    """Model of what stations hear of bursts, all of which are known. At each burst of a disturbed stretch
    every station reads the whole stretch again, nanosecond by nanosecond where the line changes. The settings
    are those of ``Station``."""

    def __init__(self, stations: dict[str, Station]) -> None:
        self.stations = stations
        self.ears = {name: Ear(Timeline(), station.receiver.baud_now) for name, station in stations.items()}
        self.collisions = dict.fromkeys(stations, 0)
        self.packets = 0
        self._clean: list[Sent] = []
        self._cluster: list[Sent] = []
        self._decoder = PacketDecoder()

    def play(self, bursts: Iterable[Sent]) -> None:
        for burst in sorted(bursts, key=lambda each: each.start_ns):
            self._end(burst.start_ns)
            self._begin(burst)
        self._end(10**15)

    def off_ns(self, burst: Sent) -> int:
        return self.end_ns(burst) + self.stations[burst.station].release_ns

    def end_ns(self, burst: Sent) -> int:
        return burst.start_ns + characters_ns(len(burst.data), self.ears[burst.station].baud_now)

    def _begin(self, burst: Sent) -> None:
        if self.stations[burst.station].is_cut:
            return
        now_ns = burst.start_ns
        active = [each for each in self._clean + self._cluster if self.off_ns(each) > now_ns]
        is_disturbed = any(each.station != burst.station for each in active)
        if is_disturbed and all(each.station != burst.station for each in active):
            for name in {burst.station, *(each.station for each in active)}:
                self.collisions[name] += 1
        if is_disturbed or self._cluster or any(each.is_odd for each in self.stations.values()):
            self._cluster += [*self._clean, burst]
            self._clean = []
            for name, station in self.stations.items():
                if not station.is_cut:
                    ear = self.ears[name]
                    ear.got = [each for each in ear.got if each[0] <= now_ns]
                    ear.got += [each for each in self._reads(station) if each[0] > now_ns]
        else:
            self._clean.append(burst)
            for name, station in self.stations.items():
                if not station.is_cut and (name != burst.station or station.has_echo):
                    self.ears[name].hear(now_ns, burst.data, self.ears[burst.station].baud_now)

    def _end(self, now_ns: int) -> None:
        over = [each for each in self._clean if self.off_ns(each) <= now_ns]
        self._clean = [each for each in self._clean if self.off_ns(each) > now_ns]
        for burst in over:
            self._count(burst.data)
        if self._cluster and all(self.off_ns(each) <= now_ns for each in self._cluster):
            monitor = Station("", Ear(Timeline(), self.ears[self._cluster[0].station].baud_now))
            self._count(bytes(byte for _, byte in self._reads(monitor)))
            self._cluster = []

    def _count(self, data: bytes) -> None:
        self.packets += sum(hasattr(item, "is_good") for item in self._decoder.feed(data))

    def _is_low(self, at_ns: int, listener: Station) -> bool:
        """For a listener, at a time; right of it, if the line changes there."""
        if not self._first_ns <= at_ns < self._last_ns:
            return False
        lows = [
            station.is_swapped
            for station in self.stations.values()
            if station.is_stuck and not station.is_cut
        ]
        for burst in self._cluster:
            if burst.start_ns <= at_ns < self.off_ns(burst):
                if burst.station == listener.name and not listener.has_echo:
                    return False
                lows.append(self._drives_low(burst, at_ns) != self.stations[burst.station].is_swapped)
        return (bool(lows) and all(lows)) != listener.is_swapped

    def _drives_low(self, burst: Sent, at_ns: int) -> bool:
        baud = self.ears[burst.station].baud_now
        place = ((at_ns - burst.start_ns + 1) * baud - 1) // 10**9  # edges are rounded down to nanoseconds
        index, bit = divmod(place, 10)
        if index >= len(burst.data) or bit == 9:
            return False
        return bit == 0 or not burst.data[index] >> bit - 1 & 1

    def _reads(self, listener: Station) -> list[tuple[int, int]]:
        """Return the characters that a UART reads in the stretch, with the time at which each is complete."""
        baud = listener.receiver.baud_now
        self._first_ns = min(each.start_ns for each in self._cluster)
        self._last_ns = max(map(self.off_ns, self._cluster))
        times = {self.off_ns(each) for each in self._cluster}
        for burst in self._cluster:
            sent_baud = self.ears[burst.station].baud_now
            times |= {burst.start_ns + bit * 10**9 // sent_baud for bit in range(len(burst.data) * 10 + 1)}
        characters = []
        ready_ns, was_low = -1, False
        for at_ns in sorted(times):
            is_low = self._is_low(at_ns, listener)
            is_edge, was_low = is_low and not was_low, is_low
            if not is_edge or at_ns < ready_ns:
                continue
            lows = [self._is_low(at_ns + (2 * bit + 1) * 10**9 // (2 * baud), listener) for bit in range(10)]
            if lows[0]:
                byte = sum((not low) << bit for bit, low in enumerate(lows[1:9]))
                characters.append((at_ns + characters_ns(1, baud), byte))
            ready_ns = at_ns + (19 if lows[0] else 1) * 10**9 // (2 * baud)
        return characters
