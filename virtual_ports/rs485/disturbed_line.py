"""A line while it is disturbed, read as it comes, and kept no further back than matters.

It is disturbed from the first burst of a stretch in which bursts overlap, or in which a driver is wrong, to
the end of the last. What was before ``now`` is decided, because bursts begin in the order of time. Of that
only as much is kept as somebody's UART is in the middle of, so that a stretch without an end costs what a
short one does. Receivers that stand alike and see the same wire are read once for all.
"""

from collections.abc import Iterable
from typing import NamedTuple

from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.vocab.segment import HeardCharacter
from virtual_ports.rs485.waveform import Driving, Lows, inverted, joined, low_line, read, without


class Ear(NamedTuple):
    """Receiver: its name, and how it hears."""

    name: str
    baud: int
    is_swapped: bool = False
    has_echo: bool = False
    line_format: LineFormat | None = None
    """Format in which it reads; None: the line's."""


class DisturbedLine:
    """Disturbed line from ``from_ns``. Times never go back; bursts are added when they begin."""

    def __init__(self, from_ns: int, line_format: LineFormat = EIGHT_N_1) -> None:
        self._format = line_format
        self.from_ns = from_ns
        self.off_ns = from_ns
        """Time at which the last driver lets go, of the bursts that have begun."""
        self._known_ns = from_ns
        self._drives: list[Driving] = []
        self._lows: dict[bool, Lows] = {False: [], True: []}
        """Lows that are decided and still matter; True: as seen with swapped wires."""
        self._again_ns: dict[Ear, int] = {}
        """Time at which each receiver's reading goes on."""
        self._own: dict[str, list[tuple[int, int]]] = {}
        """Spans in which the driver of a station was on, as far as they matter."""

    def add(self, station: str, drive: Driving) -> None:
        self._drives.append(drive)
        self._own.setdefault(station, []).append((drive.on_ns, drive.off_ns))
        self.off_ns = max(self.off_ns, drive.off_ns)

    @property
    def fastest_baud(self) -> int:
        """Maximum baud of those that drive the line now."""
        return max(drive.baud for drive in self._drives)

    def read(
        self, ears: Iterable[Ear], now_ns: int, until_ns: int, *, is_held: bool
    ) -> dict[str, tuple[HeardCharacter, ...]]:
        """Read the characters that each ear has heard since the last call's ``now_ns``, and will by
        ``until_ns`` if nobody else begins to send. All that listen have to be asked each time. ``is_held``: a
        driver that is stuck holds the line high."""
        first_ns, ahead_ns = self._known_ns, min(until_ns, self.off_ns)
        self._go_on(self._lines(first_ns, now_ns, is_held))
        self._known_ns = now_ns
        self._drives = [drive for drive in self._drives if drive.off_ns > now_ns]
        ahead = self._lines(now_ns, ahead_ns, is_held)
        lines = {way: joined(self._lows[way], lows) for way, lows in ahead.items()}
        read_once: dict[tuple[object, ...], tuple[tuple[HeardCharacter, ...], int]] = {}
        again: dict[Ear, int] = {}
        heard = {}
        for ear in ears:
            ready_ns = self._again_ns.get(ear, first_ns)
            own = () if ear.has_echo else self._sends(ear.name, ready_ns)
            line_format = ear.line_format or self._format
            key = (ear.baud, line_format, ear.is_swapped, ready_ns, own)
            if key not in read_once:
                lows = lines[ear.is_swapped]
                for on_ns, off_ns in own:
                    lows = without(lows, on_ns, off_ns)
                characters, again_ns = read(lows, ear.baud, ready_ns, now_ns, until_ns, line_format)
                read_once[key] = tuple(characters), again_ns
            heard[ear.name], again[ear] = read_once[key]
        self._again_ns = again
        self._forget(min(again.values(), default=now_ns))
        return heard

    def _lines(self, from_ns: int, to_ns: int, is_held: bool) -> dict[bool, Lows]:
        """Lows between two times, as they are and as seen with swapped wires. There is always somebody who
        drives it. A driver that is stuck and swapped holds it low, which changes nothing for what others
        send."""
        if from_ns >= to_ns:
            return {False: [], True: []}
        lows = [] if is_held else low_line(self._drives, from_ns, to_ns, self._format)
        return {False: lows, True: inverted(lows, from_ns, to_ns)}

    def _go_on(self, more: dict[bool, Lows]) -> None:
        for way, lows in more.items():
            self._lows[way] = joined(self._lows[way], lows)

    def _sends(self, name: str, from_ns: int) -> tuple[tuple[int, int], ...]:
        """Spans in which a station's driver is on, from a time on. A driver that turns off exactly at that
        time still hides the level before it: a line that is low then falls for its receiver."""
        spans = self._own.get(name)
        if not spans:
            return ()
        spans[:] = [span for span in spans if span[1] >= from_ns]
        return tuple(spans)

    def _forget(self, until_ns: int) -> None:
        """Drop what was over by then; not a low that goes on, which would seem to fall again."""
        until_ns = min(until_ns, self._known_ns - 1)
        for way, lows in self._lows.items():
            if lows and lows[0][1] <= until_ns:
                self._lows[way] = [low for low in lows if low[1] > until_ns]
