"""Live captures of the traffic at ports, as pcapng to clients of the control socket."""

import asyncio
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from hil import __version__
from hil.live.core_thread import WallClock
from hil.vocab.segment import SegmentEvent
from hil.vocab.time import SimTimeNs
from hil.vocab.wire import FrameKind
from hil.wire.pcapng import Interface, RecordKind, frame_record, header, record

BACKLOG_BYTES = 8 * 1024 * 1024
"""Maximum that may wait for a reader; more is lost, which the capture says."""
BATCH_S = 0.02
BATCH = 256
"""Time, and number of records, after which what was captured is sent to a reader, a batch in one call."""
_RECORD_BYTES = 100
"""Size of a record without its data, about."""


class Capture:
    """Capture for one reader. ``sources`` are ports, segments and CAN buses. All records have simulated time,
    counted from the wall's at 0, so that they can be compared at any speed of the bench."""

    def __init__(self, sources: Sequence[Interface], clock: WallClock) -> None:
        self.sources = sources
        self._clock = clock
        self.epoch_ns = clock.epoch_ns
        """Wall time, in ns since 1970, from which the times of its records count."""
        self._writer: asyncio.StreamWriter | None = None
        self._lost = 0
        self._loop: asyncio.AbstractEventLoop | None = None
        self._timer: asyncio.Handle | None = None
        self._waiting: list[Callable[[], bytes]] = []
        self._waiting_bytes = 0

    def begin(self, writer: asyncio.StreamWriter, loop: asyncio.AbstractEventLoop | None = None) -> None:
        """Send records to this writer from now on: in batches in turns of this loop, so that no client waits
        for them at its port; None: each at once."""
        self._writer, self._loop = writer, loop
        writer.write(header(f"hil {__version__}", self.sources))

    def flush(self) -> None:
        """Send what waits for its batch."""
        if self._timer:
            self._timer.cancel()
            self._timer = None
        waiting, self._waiting, self._waiting_bytes = self._waiting, [], 0
        if self._writer and waiting and not self._writer.is_closing():
            self._writer.write(b"".join([made() for made in waiting]))

    def _add(self, made: Callable[[], bytes], length: int) -> None:
        """Add a record, which is made in its batch."""
        self._waiting.append(made)
        self._waiting_bytes += length + _RECORD_BYTES
        if not self._loop:
            self.flush()
        elif not self._timer:
            self._timer = self._loop.call_later(BATCH_S, self.flush)
        elif len(self._waiting) == BATCH:
            self._timer.cancel()
            self._timer = self._loop.call_soon(self.flush)

    def put(
        self, source: int, event: RecordKind, data: bytes = b"", comment: str = "", at_ns: int = -1
    ) -> None:
        """Write a record of a serial line; ``at_ns``: simulated time, else now."""
        sim_ns = self._clock.sim_ns(time.time_ns()) if at_ns < 0 else at_ns
        time_ns = self.epoch_ns + sim_ns
        if self._has_room(source, time_ns):
            self._add(partial(record, source, time_ns, event, data, comment), len(data))

    def passed(self, source: int, towards: str, data: bytes) -> None:
        """Record bytes that have passed at a port, with their direction."""
        self.put(source, RecordKind.TX if towards == "board" else RecordKind.RX, data)

    def passed_at(self, source: int, towards: str, at_ns: SimTimeNs, data: bytes) -> None:
        """Record bytes that have passed at a node, with their direction and time."""
        self.put(source, RecordKind.TX if towards == "board" else RecordKind.RX, data, "", at_ns)

    def heard(self, source: int, event: SegmentEvent) -> None:
        """Record traffic of a segment: bursts with their times; readings of a disturbed line, with errors."""
        kind = RecordKind.FRAMING_ERROR if event.is_damaged else RecordKind.RX
        self.put(source, kind, event.data, event.about, event.at_ns)

    def carried(self, source: int, frames: FrameKind, event: Any) -> None:
        """Record what a bus has carried: a frame, an error, or a node's new state; by whom."""
        time_ns = self.epoch_ns + event.at_ns
        if self._has_room(source, time_ns, frames):
            self._add(lambda: frame_record(source, time_ns, frames.packed(event), event.node), 0)

    def _has_room(self, source: int, time_ns: int, frames: FrameKind | None = None) -> bool:
        """True if there is a reader that has room; it is told what it has lost."""
        writer = self._writer
        if writer is None or writer.is_closing():
            return False
        if writer.transport.get_write_buffer_size() + self._waiting_bytes > BACKLOG_BYTES:
            self._lost += 1
            return False
        if self._lost:
            self._add(partial(bytes, self._loss(source, time_ns, frames)), 0)
            self._lost = 0
        return True

    def _loss(self, source: int, time_ns: int, frames: FrameKind | None) -> bytes:
        """Record of what was lost: of all sources, at the first that has something again."""
        why = f"the reader was too slow: {self._lost} lost"
        if frames:
            return frame_record(source, time_ns, frames.lost, why, self._lost)
        return record(source, time_ns, RecordKind.LOST, comment=why, lost=self._lost)
