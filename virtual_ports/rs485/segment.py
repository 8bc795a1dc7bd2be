"""An RS485 wire with stations: half duplex, driver enable, collisions, and faults.

Pure: integer nanoseconds of simulated time come in as arguments. A burst, the bytes that a station sends in
one go, is the unit of work: one that nothing disturbs costs the same for two stations and for 252, because it
is split into packets once and only those are told that it concerns.

Not modelled: the cable's length (no delay, no reflections), rise times, a receiver's threshold (``waveform``
says what contention reads as), noise in start, parity and stop bits.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from hil.vocab.faults import LINE, OF_FRAMINGS, ON_LINE, SEGMENT, STATION, Fault
from hil.vocab.framing import Framing, Item, Splitter
from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.vocab.monitoring import HealthProblem
from hil.vocab.segment import HeardCharacter, Receiver, SegmentEvent
from hil.vocab.time import FOREVER, NS_PER_MS, Clock, SimTimeNs
from hil.vocab.wire import Report, WireTap
from hil.wire.byte_faults import ByteFault, ByteFaults, Chance
from hil.wire.pcapng import Interface
from hil.wire.serial_line import character_ns
from virtual_ports.rs485.disturbance import Burst, Disturbance
from virtual_ports.rs485.line_levels import LineLevels
from virtual_ports.rs485.reactions import StationReactions
from virtual_ports.rs485.segment_reports import segment_problems, segment_report
from virtual_ports.rs485.stations import Station, Stations
from virtual_ports.rs485.stats import SegmentStats, StationStats
from virtual_ports.rs485.waveform import Driving


class GhostNode:
    """Node that answers all that is sent to an address. ``answer(at_ns, raw)`` sends for it, at that time."""

    def __init__(
        self, framing: Framing, address: int, baud: int, answer: Callable[[int, bytes], None]
    ) -> None:
        self.baud_now = baud
        self._framing = framing
        self._address = address
        self._answer = answer

    def hear(self, start_ns: int, data: bytes, baud: int, packets: object = None) -> None:
        character_ns = 10 * 10**9 / baud
        for characters, raw in self._framing.answers(data, self._address):
            self._answer(start_ns + round(characters * character_ns), raw)

    def hear_characters(self, characters: object) -> None:
        """Ignored: in a collision it understands nothing."""

    def retract(self, after_ns: int) -> None:
        """Ignored: it finishes an answer that it has begun."""


class _Clean(NamedTuple):
    """Burst that nothing has disturbed yet, and the splitter as it was before it."""

    burst: Burst
    items: Sequence[Item]
    before: Splitter


class Rs485Segment:
    """Segment: stations on one wire, as ``hil.vocab.segment`` has it. Nobody senses the line before it sends:
    two that send at once collide. ``framing`` says what on it is a packet, and for whom; ``line_format`` is
    that of all stations' characters.

    All that happens here happens at times of ``clock``, in their order: a burst begins, what disturbed it is
    told, it ends. Nothing else moves the line on, so watchers change nothing.

    Long because bursts, faults and addresses change the same wire at the same times.
    """

    kind = "segments"
    frames = None

    def __init__(
        self, clock: Clock, framing: Framing, line_format: LineFormat = EIGHT_N_1, name: str = ""
    ) -> None:
        self.name = name
        self.framing = framing
        self.line_format = line_format
        self._bits, self._has_parity = line_format.bits, line_format.has_parity
        self.stats = SegmentStats()
        self.stations = Stations()
        self.reactions = StationReactions(self.stations)
        self.watchers: list[Callable[[SegmentEvent], None]] = []
        self.noise: dict[int, ByteFaults] = {}
        """Noise of the wire, by the numbers of faults."""
        self._clock = clock
        self._splitter = framing.splitter()
        self._clean, self._babbling = list[_Clean](), set[int]()
        self._disturbance: Disturbance | None = None
        self._levels: LineLevels | None = None
        self._waiting: set[str] = set()
        """Stations that have a burst to send when the present one is out."""

    # ---- stations ----

    def join(self, station: str, receiver: Receiver) -> None:
        self.stations.join(Station(station, receiver))
        self.stats.stations[station] = StationStats()

    def set_address(self, station: str, address: int | None) -> None:
        self.stations.set_address(station, address)

    def set_polling(self, station: str, is_polling: bool) -> None:
        (self.stations.busy.discard if is_polling else self.stations.busy.add)(station)

    def set_echo(self, station: str, has_echo: bool) -> None:
        self.stations[station].has_echo = has_echo

    @property
    def baud(self) -> int:
        first = next(iter(self.stations.values()), None)
        return first.receiver.baud_now if first else 0

    def has(self, station: str) -> bool:
        return station in self.stations

    def baud_of(self, station: str) -> int:
        return self.stations[station].receiver.baud_now

    def give_way(self, station: str) -> None:
        self.stations[station].left_address = self.stations[station].address
        self.stations.rewire(station)

    def left_address(self, station: str) -> int | None:
        return self.stations[station].left_address

    def speeds(self) -> Mapping[str, int]:
        return {name: station.receiver.baud_now for name, station in self.stations.items()}

    def addresses(self) -> Mapping[str, int]:
        return {name: of.address for name, of in self.stations.items() if of.address is not None}

    def clashes_with(self, address: int, but: str) -> list[str]:
        members = self.stations.by_address.get(address, {})
        return [name for name, member in members.items() if name != but and not member.is_cut]

    def clashes(self) -> Mapping[int, list[str]]:
        several = [at for at, of in self.stations.by_address.items() if at is not None and len(of) > 1]
        on_line = {address: self.clashes_with(address, but="") for address in several}
        return {address: names for address, names in on_line.items() if len(names) > 1}

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        return self.stats.counters(elapsed_ns)

    def report(self, elapsed_ns: int, taps: Sequence[WireTap], cards: Mapping[str, Any]) -> Report:
        return segment_report(self.name, self, elapsed_ns, taps, cards)

    def problems(self, taps: Sequence[WireTap]) -> Iterator[HealthProblem]:
        return segment_problems(self.name, self, taps)

    def about(self, cards: Mapping[str, Any]) -> str:
        return ""

    def interface(self, name: str) -> Interface:
        return Interface(name, self.framing.name, self.baud, self.line_format)

    # ---- faults (hil.vocab.faults) ----

    def fault_targets(self, station: str) -> Collection[str]:
        return (STATION, ON_LINE) if station else (SEGMENT, LINE)

    def fault_problem(self, fault: Fault, active: Iterable[Fault]) -> str | None:
        if fault.kind in OF_FRAMINGS and fault.kind not in self.framing.faults:
            return f"{fault.kind} means nothing on a line of {self.framing.name}"
        return None

    def inject(self, number: int, fault: Fault, station: str) -> None:
        if fault.kind == "node_babble":
            self._babbling.add(number)
            self._babble(number, fault, station, Chance(int(fault.number("seed"))), self._clock.now_ns)
        elif fault.kind == "wire_noise":
            self.noise[number] = ByteFaults(
                ByteFault(bit_error_rate=fault.number("rate")), int(fault.number("seed"))
            )
        elif fault.kind == "node_clash":
            name = f"fault {number}"
            address = int(fault.number("address"))
            self.join(name, GhostNode(self.framing, address, self.baud, partial(self._answer, name)))
            self.set_address(name, address)
        elif fault.kind.startswith("packet_"):
            transform = self.framing.fault(fault.kind, fault.number("rate"), int(fault.number("seed")))
            self.stations[station].transforms[number] = transform
        else:
            self.stations[station].wire_faults[number] = fault
            self.stations.rewire(station)

    def clear(self, number: int, fault: Fault, station: str) -> None:
        self.noise.pop(number, None)
        self._babbling.discard(number)  # it notices when it wants to speak again
        if fault.kind == "node_clash":
            self.stations.leave(f"fault {number}")
        elif fault.layer == "wire" and fault.kind != "wire_noise":
            del self.stations[station].wire_faults[number]
            self.stations.rewire(station)
        elif station in self.stations:
            self.stations[station].transforms.pop(number, None)

    def _babble(self, number: int, fault: Fault, station: str, chance: Chance, now_ns: SimTimeNs) -> None:
        """Send a burst of nonsense, and the next when it is time, until the fault is over."""
        if number not in self._babbling:
            return
        period_ns = round(fault.number("every_ms") * NS_PER_MS)
        if self.has(station):
            count = int(fault.number("bytes"))
            data = bytes(chance.bits() & 0xFF for _ in range(count))
            self._speak(station, data, now_ns)
            # A burst that came before this one is out would be lost, and its bytes drawn for nothing.
            period_ns = max(period_ns, character_ns(count, self.baud_of(station), self._bits))
        self._clock.at(now_ns + period_ns, partial(self._babble, number, fault, station, chance))

    def _answer(self, station: str, at_ns: int, raw: bytes) -> None:
        """Send for a station that a fault has put here."""
        self._clock.at(at_ns, partial(self._speak, station, raw))

    def _speak(self, station: str, raw: bytes, now_ns: SimTimeNs) -> None:
        if self.has(station):
            self.transmit(station, now_ns, raw, self.baud_of(station))

    # ---- levels, for pictures of the wire ----

    def record_levels(self, on: bool) -> None:
        self._levels = LineLevels(self._clock.now_ns, self.line_format) if on else None

    def take_levels(self, until_ns: int) -> list[tuple[int, int]]:
        if not self._levels:
            return []
        is_held = any(
            each.is_stuck and not each.is_swapped and not each.is_cut for each in self.stations.values()
        )
        return self._levels.drain(until_ns, is_held=is_held)

    # ---- the wire ----

    def transmit(
        self, station: str, start_ns: SimTimeNs, data: bytes, baud: int, sent_format: LineFormat | None = None
    ) -> None:
        if start_ns > self._clock.now_ns:
            self._clock.at(start_ns, partial(self._begin, station, data, baud, sent_format))
        else:  # a processor's begins some microseconds back
            self._begin(station, data, baud, sent_format, start_ns)

    def _begin(
        self, station: str, data: bytes, baud: int, sent_format: LineFormat | None, now_ns: SimTimeNs
    ) -> None:
        self._settle(now_ns)
        sender = self.stations.get(station)
        if sender is None:  # it has left meanwhile
            return
        end_ns = self.stats.end_ns(station)
        if end_ns > now_ns:
            self._wait(station, end_ns, partial(self._begin, station, data, baud, sent_format))
            return
        for transform in sender.transforms.values():
            data = transform(data)
        # What a fault of the sender has changed goes out with its own parity; noise on the wire breaks that.
        meant = data
        for noise in self.noise.values():
            data = b"".join(piece for _, piece in noise.apply(data))
        if not data:
            return
        bits = sent_format.bits if sent_format else self._bits
        end_ns = now_ns + character_ns(len(data), baud, bits)
        burst = Burst(station, now_ns, data, baud, now_ns, end_ns + sender.release_ns, sent_format)
        own = self.stats.stations[station]
        own.bursts += 1
        own.bytes += len(data)
        # It has sent, and counts so, though nobody hears it.
        if sender.is_cut:
            return
        if self._levels:
            self._levels.add(
                Driving(now_ns, data, baud, burst.on_ns, burst.off_ns, sender.is_swapped, sent_format)
            )
        is_alone = self.stats.begin(station, len(data), now_ns, end_ns, burst.off_ns)
        if is_alone and not self._disturbance and not self.stations.is_odd and not sent_format:
            self._bring(burst, meant)
        else:
            self._disturb(burst)
        self._clock.at(burst.off_ns, self._settle)

    def release(self, station: str, at_ns: SimTimeNs) -> None:
        self._settle(at_ns)
        mine = next((each.burst for each in self._clean if each.burst.station == station), None)
        if mine is None:  # it sends nothing, or the line is disturbed already
            return
        now_ns = self._clock.now_ns
        others = [each.burst for each in self._clean if each.burst is not mine]
        self._splitter = self._clean[0].before
        self._clean.clear()
        cut = mine._replace(off_ns=max(at_ns, mine.start_ns + 1))
        self._disturbance = self._disturbed(cut, others, now_ns)
        self._clock.at(max(cut.off_ns, now_ns + 1), self._settle)

    def _wait(self, station: str, end_ns: int, then: Callable[[SimTimeNs], None]) -> None:
        """Keep the next burst of a station that still sends, as by a fault. One can wait; more is lost."""

        def begin(now_ns: SimTimeNs) -> None:
            self._waiting.discard(station)
            then(now_ns)

        if station not in self._waiting:
            self._waiting.add(station)
            self._clock.at(end_ns, begin)

    def _settle(self, now_ns: SimTimeNs) -> None:
        """Count, and tell watchers, what has been on the line to its end by now."""
        self.stats.settle(now_ns)
        while self._clean and self._clean[0].burst.off_ns <= now_ns:
            clean = self._clean.pop(0)
            self.stats.count(clean.items)
            if not self.watchers:
                continue
            wrong = dict.fromkeys(item.fault for item in clean.items)
            about = " ".join([clean.burst.station, *filter(None, wrong)])
            for watcher in self.watchers:
                watcher(SegmentEvent(SimTimeNs(clean.burst.start_ns), clean.burst.data, about))
        if self._disturbance and self._disturbance.off_ns <= now_ns:
            over_ns = self._disturbance.end(now_ns)
            self._disturbance = None
            self._listen_for_silence(over_ns)

    def _bring(self, burst: Burst, meant: bytes) -> None:
        """Deliver a burst that nothing disturbs, so far. ``meant``: its bytes without noise."""
        # If another burst disturbs this one, both are split again from here.
        before = self._splitter.copy()
        start_ns, data, baud = SimTimeNs(burst.start_ns), burst.data, burst.baud
        items, addresses, is_for_all, over_ns = self._splitter.burst(data, start_ns, baud)
        if over_ns < FOREVER:
            self._listen_for_silence(over_ns)
        self._clean.append(_Clean(burst, items, before))
        packets = items if is_for_all else None
        concerned = self.stations.concerned(addresses)
        if self._has_parity and data != meant:
            self._bring_spoiled(burst, meant, concerned)
            return
        sender = burst.station
        for station in concerned:
            if not station.is_cut and (station.name != sender or station.has_echo):
                station.receiver.hear(start_ns, data, baud, packets)

    def _bring_spoiled(self, burst: Burst, meant: bytes, concerned: Iterable[Station]) -> None:
        """Deliver a burst with noise on a line with parity: a character of which an odd number of bits are
        wrong has the parity bit of what was meant. A receiver at another speed hears what it reads anyway."""
        baud, parity = burst.baud, self.line_format.parity_bit
        characters = tuple(
            HeardCharacter(
                burst.start_ns + character_ns(at + 1, baud, self._bits),
                byte,
                False,
                parity(byte) != parity(was),
            )
            for at, (byte, was) in enumerate(zip(burst.data, meant, strict=True))
        )
        for station in concerned:
            if station.is_cut or (station.name == burst.station and not station.has_echo):
                continue
            if station.receiver.baud_now == baud:
                station.receiver.hear_characters(characters)
            else:
                station.receiver.hear(SimTimeNs(burst.start_ns), burst.data, baud)

    def _listen_for_silence(self, over_ns: SimTimeNs) -> None:
        """Count what is a packet once the line has been silent until then."""
        if over_ns < FOREVER:
            self._clock.at(max(over_ns, self._clock.now_ns + 1), self._be_silent)

    def _be_silent(self, now_ns: SimTimeNs) -> None:
        if not self._disturbance:  # at the end of which it is known what has been on the line
            self.stats.count(self._splitter.silence(now_ns))

    def _disturb(self, burst: Burst) -> None:
        """Disturb the line by a burst that another overlaps, or on a line that is not right: what is on the
        line is not what it was taken for."""
        if self._disturbance:
            self._disturbance.add(burst)
            return
        before = [clean.burst for clean in self._clean]
        if self._clean:
            self._splitter = self._clean[0].before
            self._clean.clear()
        self._disturbance = self._disturbed(burst, before, SimTimeNs(burst.start_ns))

    def _disturbed(self, burst: Burst, before: Sequence[Burst], now_ns: SimTimeNs) -> Disturbance:
        return Disturbance(
            burst,
            before,
            self.stations,
            self._clock,
            self._splitter,
            self.stats,
            self.watchers,
            self.line_format,
            now_ns,
        )
