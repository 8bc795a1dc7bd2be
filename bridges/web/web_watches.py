"""Watches of one page: which there are, and what of them the page gets on its turn."""

from collections.abc import Collection, Mapping
from typing import Any

from bridges.web.outbox import LongText, Outbox
from bridges.web.page_rows import WatchAnswer
from bridges.web.shared_reading import SharedReading
from bridges.web.streams import (
    SLOW_S,
    AxisSamples,
    BenchEvents,
    DoorClock,
    PageStream,
    PassingItems,
    RunsProgress,
    ToldReading,
    rows_per_s,
)
from bridges.web.web_messages import NAME, NAMES, NUMBER, WHOLE, taken
from bridges.web.wire_streams import BusFrames, LinePackets, PortBytes, RecordedItems, Records
from hil.vocab.address import owner_of
from hil.vocab.desk_protocol import Desk, Source
from hil.vocab.verbs import VerbRefused
from hil.wire.json_text import json_text

MOST_WATCHES = 256
MOST_WIRES = 16
"""Maximum number of watches of packets, frames and bytes: each may hold up to half a megabyte."""
MOST_READINGS_HZ = 4.0
KINDS = ("samples", "packets", "frames", "bytes", "runs", "events", "status", "faults", "clock")
_FORMS = {"what": NAME, "target": NAME, "fields": NAMES, "rate_Hz": NUMBER, "points": WHOLE}
_DEFAULTS: Mapping[str, Any] = {"target": "", "fields": [], "rate_Hz": None, "points": 1}


class PageWatches:
    """Watches of a page of ``source``. ``shared``, ``records``: readings and segments' events, for all pages;
    ``samples_per_s``: limit of all its samples together."""

    def __init__(
        self,
        desk: Desk,
        source: Source,
        shared: Mapping[str, SharedReading],
        records: Records,
        samples_per_s: float,
    ) -> None:
        self._desk, self._source, self._samples_per_s = desk, source, samples_per_s
        self._shared, self._records = shared, records
        self._streams: dict[int, tuple[str, str, PageStream]] = {}
        """Kind, target and stream by number."""
        self._last = 0
        self._lost_before = 0

    @property
    def turn_s(self) -> float:
        """Time between the turns that the page wants."""
        return min((stream.turn_s for _, _, stream in self._streams.values()), default=SLOW_S)

    def __len__(self) -> int:
        return len(self._streams)

    @property
    def lost(self) -> int:
        """Number of samples and items that the page never got."""
        return self._lost_before + sum(stream.lost for _, _, stream in self._streams.values())

    def open(self, given: Mapping[str, Any]) -> WatchAnswer:
        """Begin a watch; answers its number.

        Raises:
            VerbRefused: there is no such thing, or too much is watched.
        """
        values = taken(given, _FORMS, _DEFAULTS)
        if len(self._streams) >= MOST_WATCHES:
            raise VerbRefused("not_now", f"{MOST_WATCHES} watches are open already; end one")
        what, target = values["what"], values["target"]
        stream = self._stream(self._last + 1, what, target, values)
        self._last += 1
        self._streams[self._last] = what, target, stream
        return {"watch": self._last}

    def close(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """End a watch, also one that has ended."""
        self._end(taken(given, {"watch": WHOLE}, {})["watch"])
        return {}

    def recorded(self, number: int) -> RecordedItems:
        """Watch of packets or frames with this number. Raises VerbRefused: it is none."""
        _, _, stream = self._streams.get(number, ("", "", None))
        if not isinstance(stream, RecordedItems):
            raise VerbRefused("no_place", f"watch {number} is none of packets or frames")
        return stream

    def fill(self, outbox: Outbox, now_s: float) -> None:
        """Give the page what came since its last turn: all samples in one message."""
        blocks = []
        for _, _, stream in self._streams.values():
            match stream.next_message(now_s):
                case bytes(block):
                    blocks.append(block)
                case str() | LongText() as text:
                    outbox.put(text)
        if blocks:
            outbox.put(b"".join(blocks))

    def drop(self) -> None:
        """Drop what came since the page's last turn: it does not read."""
        for _, _, stream in self._streams.values():
            stream.drop()

    def devices_changed(self, names: Collection[str], outbox: Outbox) -> None:
        """End the watches of devices that were added, removed or exchanged: their fields may be others."""
        for number, (what, target, _) in list(self._streams.items()):
            if what in ("samples", "bytes") and owner_of(target) in names:
                self._end(number)
                outbox.put(json_text({"closed": {"watch": number, "why": f"{target} was changed"}}))

    def close_all(self) -> None:
        for number in list(self._streams):
            self._end(number)

    def _end(self, number: int) -> None:
        if found := self._streams.pop(number, None):
            self._lost_before += found[2].lost
            found[2].close()

    def _stream(self, number: int, what: str, target: str, values: Mapping[str, Any]) -> PageStream:
        desk, source = self._desk, self._source
        rate_Hz: float | None = values["rate_Hz"]
        match what:
            case "samples":
                if not (fields := values["fields"]):
                    raise VerbRefused("bad_parameter", "fields: name those that are wanted")
                rate, points = _rate(rate_Hz, 60.0, self._samples_per_s), values["points"]
                self._check_rate(rows_per_s(rate, points))
                return AxisSamples(desk, source, number, target, fields, rate, points)
            case "packets":
                self._check_wires()
                return LinePackets(desk, source, number, target, self._records)
            case "frames":
                self._check_wires()
                return BusFrames(desk, source, number, target, self._records)
            case "bytes":
                self._check_wires()
                return PortBytes(desk, source, number, target)
            case "runs":
                return RunsProgress(desk, source, number)
            case "events":
                return BenchEvents(desk, source, number)
            case "status" | "faults" | "clock":
                rate = _rate(rate_Hz, MOST_READINGS_HZ, MOST_READINGS_HZ)
                return (
                    DoorClock(number, rate)
                    if what == "clock"
                    else ToldReading(self._shared[what], number, rate)
                )
        raise VerbRefused("bad_parameter", f"what: there is no {what[:80]!r}; there are {', '.join(KINDS)}")

    def _check_wires(self) -> None:
        if sum(isinstance(each, PassingItems) for _, _, each in self._streams.values()) >= MOST_WIRES:
            raise VerbRefused("not_now", f"{MOST_WIRES} wires and ports are watched already; end a watch")

    def _check_rate(self, rows: float) -> None:
        others = [each.rows_per_s for _, _, each in self._streams.values() if isinstance(each, AxisSamples)]
        if sum(others) + rows > self._samples_per_s:
            raise VerbRefused(
                "bad_parameter",
                f"rate_Hz: a page gets up to {self._samples_per_s:,} samples a second of all axes together;"
                " ask for less, or end other watches",
            )


def _rate(given: float | None, default: float, most: float) -> float:
    rate = default if given is None else float(given)
    if not 0.01 <= rate <= most:
        raise VerbRefused("bad_parameter", f"rate_Hz: write 0.01 to {most:g}")
    return rate
