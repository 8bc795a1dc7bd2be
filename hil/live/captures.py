"""Live captures: what passes at ports, as pcapng to whoever asked for it over the control socket."""

import asyncio
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from hil import __version__
from hil.vocab.ports import Tap
from hil.vocab.segment import SegmentEvent, SegmentView
from hil.wire.pcapng import Event, header, record

if TYPE_CHECKING:
    from hil.daemon import Daemon

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


def open_capture(daemon: "Daemon", sources: Sequence[str]) -> tuple[Capture, Callable[[], None]]:
    """A capture of ports and segments by their names, and what ends it.

    Raises:
        KeyError: there is none of such a name.
    """
    homes = {name: _taps(daemon, name) for name in sources if name not in daemon.bench.segments}
    capture = Capture(sources, daemon.epoch_ns)
    ends: list[Callable[[], None]] = []
    for index, name in enumerate(sources):
        if name in homes:
            tap = capture.tap(index)
            homes[name].append(tap)
            ends.append(partial(homes[name].remove, tap))
        else:
            ends.append(_capture_segment(daemon.bench.segments[name], capture, index))

    def end() -> None:
        for each in ends:
            each()

    return capture, end


def _capture_segment(segment: SegmentView, capture: Capture, index: int) -> Callable[[], None]:
    """Each burst with its time; what a disturbed line reads as, with errors."""

    def put(event: SegmentEvent) -> None:
        kind = Event.FRAMING_ERROR if event.is_damaged else Event.RX
        capture.put(index, kind, event.data, event.about, event.at_ns)

    return watch_segment(segment, put)


def watch_port(daemon: "Daemon", name: str, tap: Tap) -> Callable[[], None]:
    """Call with all that passes at a port; answers what ends it."""
    home = _taps(daemon, name)
    home.append(tap)
    return partial(home.remove, tap)


def watch_segment(segment: SegmentView, put: Callable[[SegmentEvent], None]) -> Callable[[], None]:
    """Call with what was on the line, when it is over; answers what ends it."""
    segment.watchers.append(put)
    return partial(segment.watchers.remove, put)


def _taps(daemon: "Daemon", name: str) -> list[Tap]:
    if name in daemon.real:
        return daemon.real[name].taps
    if name in daemon.tap_sessions:
        return daemon.tap_sessions[name].taps
    return daemon.sessions[name].taps


def names(daemon: "Daemon") -> list[str]:
    """What can be captured."""
    return [*daemon.bench.segments, *daemon.sessions, *daemon.tap_sessions, *daemon.real]
