"""Disturbances of a segment: stretches of time, and what receivers and watchers make of them."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from hil.vocab.framing import Splitter
from hil.vocab.line_format import LineFormat
from hil.vocab.segment import HeardCharacter, SegmentEvent
from hil.vocab.time import FOREVER, Clock, SimTimeNs
from hil.wire.serial_line import character_ns
from virtual_ports.rs485.disturbed_line import DisturbedLine, Ear
from virtual_ports.rs485.stations import Station
from virtual_ports.rs485.stats import SegmentStats
from virtual_ports.rs485.waveform import Driving

MONITOR = ""
"""Name of the listener that the statistics come from."""
WINDOW_CHARACTERS = 64
"""Number of characters that a disturbed line is read ahead at a time, at the speed of its fastest sender."""
PIECE_BYTES = 256
"""Minimum number of bytes that watchers are shown of a disturbed line at a time, or the rest when it ends."""


class Burst(NamedTuple):
    """Bytes that a station sends without a pause; its driver is on from ``on_ns`` to ``off_ns``."""

    station: str
    start_ns: int
    data: bytes
    baud: int
    on_ns: int
    off_ns: int
    sent_format: LineFormat | None = None
    """Format of its characters, where it is not the line's."""


class Disturbance:
    """Disturbance from ``burst``, which is not alone on the line, meets a wrong one, or is cut short at
    ``now_ns``, until ``end``.

    ``before`` is what is on the line already, and was taken for undisturbed; ``splitter`` is the monitor's,
    as it was before all of them.
    """

    def __init__(
        self,
        burst: Burst,
        before: Sequence[Burst],
        stations: Mapping[str, Station],
        clock: Clock,
        splitter: Splitter,
        stats: SegmentStats,
        watchers: Iterable[Callable[[SegmentEvent], None]],
        line_format: LineFormat,
        now_ns: SimTimeNs,
    ) -> None:
        first = before[0] if before else burst
        self._stations = stations
        self._clock = clock
        self._splitter = splitter
        self._stats = stats
        self._watchers = watchers
        self._line = DisturbedLine(first.on_ns, line_format)
        self._bits = line_format.bits
        self._told: dict[str, tuple[HeardCharacter, ...]] = {}
        """Characters that were read last, by station."""
        self._told_ns: int = FOREVER
        """Time up to which receivers know what they hear. What they knew of later was taken back."""
        self._tell_ns: int = FOREVER
        """Time at which they are told more."""
        self._piece: list[HeardCharacter] = []
        """Characters that watchers were not shown yet."""
        self._piece_ns = first.start_ns
        self._piece_of: dict[str, None] = {}
        """Stations that have sent meanwhile."""
        self._monitor = Ear(MONITOR, 0)
        for each in before:
            self._drive(each)
        self._begin(burst, now_ns, is_surprise=bool(before) or now_ns > burst.start_ns)

    @property
    def off_ns(self) -> int:
        """Time at which the last driver lets go, of the bursts that have begun."""
        return self._line.off_ns

    def add(self, burst: Burst) -> None:
        self._begin(burst, SimTimeNs(burst.start_ns), is_surprise=False)

    def _begin(self, burst: Burst, now_ns: SimTimeNs, *, is_surprise: bool) -> None:
        """Begin a burst: take back what everybody hears from its start on. They are told before the next
        character can be complete, and not sooner: of all that begins about then at once."""
        self._drive(burst)
        # All was taken back already, and is told anew at that time.
        if self._told_ns < self._tell_ns < FOREVER:
            return
        baud = 1
        for station in self._stations.values():
            if not station.is_cut:
                station.receiver.retract(now_ns)
                baud = max(baud, station.receiver.baud_now)
        told = {id(characters): characters for characters in self._told.values()}.values()
        under_way = [each.at_ns for characters in told for each in characters if each.at_ns > now_ns]
        # A low that was too short for a start bit may go on as one: half a bit of the next character is over.
        soonest_ns = now_ns + character_ns(1, baud, self._bits) * 19 // 20
        # What ends after the window that was read is not known yet, and may have begun before now.
        window_ns = self._tell_ns if self._tell_ns > now_ns else now_ns + 1
        next_ns = now_ns + 1 if is_surprise else min([soonest_ns, window_ns, *under_way])
        self._told_ns = now_ns
        self._tell_at(next_ns)

    def _drive(self, burst: Burst) -> None:
        is_swapped = burst.station in self._stations and self._stations[burst.station].is_swapped
        drive = Driving(
            burst.start_ns,
            burst.data,
            burst.baud,
            burst.on_ns,
            burst.off_ns,
            is_swapped,
            burst.sent_format,
        )
        self._line.add(burst.station, drive)
        if burst.start_ns == self._line.from_ns:  # of several, the order in which they came does not matter
            self._monitor = Ear(MONITOR, max(self._monitor.baud, burst.baud))
        self._piece_of[burst.station] = None

    def _tell_at(self, at_ns: int) -> None:
        self._tell_ns = at_ns
        if at_ns < FOREVER:
            self._clock.at(at_ns, self._tell)

    def _tell(self, now_ns: SimTimeNs) -> None:
        if now_ns == self._tell_ns:
            until_ns = now_ns + character_ns(WINDOW_CHARACTERS, self._line.fastest_baud, self._bits)
            self._read(now_ns, until_ns if until_ns < self._line.off_ns else FOREVER)
            if len(self._piece) >= PIECE_BYTES:
                self._show_piece(now_ns)

    def _read(self, now_ns: int, until_ns: int) -> None:
        """Tell receivers what is new for them up to a time; keep what the monitor has decided."""
        told_ns = self._told_ns
        members = [each for each in self._stations.values() if not each.is_cut and told_ns < FOREVER]
        ears = [
            Ear(each.name, each.receiver.baud_now, each.is_swapped, each.has_echo, each.format_now)
            for each in members
        ]
        is_held = any(
            each.is_stuck and not each.is_swapped and not each.is_cut for each in self._stations.values()
        )
        heard = self._line.read([*ears, self._monitor], now_ns, until_ns, is_held=is_held)
        fresh: dict[int, tuple[HeardCharacter, ...]] = {}
        for member in members:
            characters = heard[member.name]
            if id(characters) not in fresh:
                fresh[id(characters)] = tuple(each for each in characters if each.at_ns > told_ns)
            if news := fresh[id(characters)]:
                member.receiver.hear_characters(news)
        self._piece += [each for each in heard[MONITOR] if each.at_ns <= now_ns]
        self._told, self._told_ns = heard, until_ns
        self._tell_at(until_ns)

    def end(self, now_ns: int) -> SimTimeNs:
        """End it, as the last driver has let go: what is under way reads an idle line. Returns when silence
        completes what the monitor holds."""
        self._read(now_ns, FOREVER)
        self._piece += [each for each in self._told[MONITOR] if each.at_ns > now_ns]
        return self._show_piece(now_ns)

    def _show_piece(self, now_ns: int) -> SimTimeNs:
        data = bytes(each.byte for each in self._piece)
        times_ns = [each.at_ns for each in self._piece]
        heard = self._splitter.characters(data, times_ns, self._monitor.baud)
        self._stats.count(heard.items)
        senders = " and ".join(self._piece_of)
        about = (
            f"collision of {senders}" if len(self._piece_of) > 1 else f"{senders} on a line that is not right"
        )
        for watcher in self._watchers:
            watcher(SegmentEvent(SimTimeNs(self._piece_ns), data, about, is_damaged=True))
        self._piece.clear()
        self._piece_ns, self._piece_of = now_ns, dict.fromkeys(self._stats.senders)
        return heard.over_ns
