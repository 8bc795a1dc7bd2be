"""Live captures: what passes at ports, as pcapng to whoever asked for it over the control socket."""

import asyncio
import time
from collections.abc import Callable, Sequence
from functools import partial

from hil import __version__
from hil.live.clock import WallClock
from hil.live.places import Places
from hil.sim.bench import BenchRuntime
from hil.vocab.ports import Tap
from hil.vocab.segment import SegmentEvent, SegmentView
from hil.wire.pcapng import Event, header, record

BACKLOG_BYTES = 8 * 1024 * 1024
"""What may wait for a reader; more is lost, which the capture says."""


class Capture:
    """One reader's. ``sources`` are names of ports, in the order of the capture's interfaces."""

    def __init__(self, sources: Sequence[str], epoch_ns: int) -> None:
        self.sources = sources
        self._epoch_ns = epoch_ns
        self._writer: asyncio.StreamWriter | None = None
        self._is_losing = False

    def begin(self, writer: asyncio.StreamWriter) -> None:
        """From now on records go to this writer."""
        self._writer = writer
        writer.write(header(f"hil {__version__}", self.sources))

    def put(self, source: int, event: Event, data: bytes = b"", comment: str = "", at_ns: int = -1) -> None:
        """A record; ``at_ns``: simulated time, else now."""
        writer = self._writer
        if writer is None or writer.is_closing():
            return
        time_ns = time.time_ns() if at_ns < 0 else self._epoch_ns + at_ns
        if writer.transport.get_write_buffer_size() > BACKLOG_BYTES:
            self._is_losing = True
            return
        if self._is_losing:
            self._is_losing = False
            writer.write(record(source, time_ns, Event.LOST, comment="the reader was too slow"))
        writer.write(record(source, time_ns, event, data, comment))

    def tap(self, source: int) -> Tap:
        """For a port: which way, and the bytes."""

        def put(towards: str, data: bytes) -> None:
            self.put(source, Event.TX if towards == "board" else Event.RX, data)

        return put

    def segment(self, source: int) -> Callable[[SegmentEvent], None]:
        """For a segment: each burst with its time; what a disturbed line reads as, with errors."""

        def put(event: SegmentEvent) -> None:
            kind = Event.FRAMING_ERROR if event.is_damaged else Event.RX
            self.put(source, kind, event.data, event.about, event.at_ns)

        return put


class Captures:
    """What passes at places and on segments, for whoever wants to see it."""

    def __init__(self, bench: BenchRuntime, places: Places, clock: WallClock) -> None:
        self._bench = bench
        self._places = places
        self._clock = clock

    @property
    def names(self) -> list[str]:
        """What can be captured: segments, and places by their labels."""
        return [*self._bench.segments, *self._places]

    def open(self, sources: Sequence[str]) -> tuple[Capture, Callable[[], None]]:
        """A capture of places and segments by their names, and what ends it.

        Raises:
            KeyError: there is none of such a name.
        """
        segments = self._bench.segments
        for name in sources:
            if name not in segments and name not in self._places:
                raise KeyError(name)
        capture = Capture(sources, self._clock.epoch_ns)
        ends = [
            watch_segment(segments[name], capture.segment(index))
            if name in segments
            else self.watch(name, capture.tap(index))
            for index, name in enumerate(sources)
        ]

        def end() -> None:
            for each in ends:
                each()

        return capture, end

    def watch(self, label: str, tap: Tap) -> Callable[[], None]:
        """Call with all that passes at a place; answers what ends it. Raises KeyError: there is none."""
        listeners = self._places[label].listeners
        listeners.append(tap)
        return partial(listeners.remove, tap)


def watch_segment(segment: SegmentView, put: Callable[[SegmentEvent], None]) -> Callable[[], None]:
    """Call with what was on the line, when it is over; answers what ends it."""
    segment.watchers.append(put)
    return partial(segment.watchers.remove, put)
