"""Live captures of the traffic at ports, as pcapng to clients of the control socket."""

import asyncio
import time
from collections.abc import Sequence
from typing import Any

from hil import __version__
from hil.live.core_thread import WallClock
from hil.vocab.segment import SegmentEvent
from hil.vocab.time import SimTimeNs
from hil.vocab.wire import FrameKind
from hil.wire.pcapng import Interface, RecordKind, frame_record, header, record

BACKLOG_BYTES = 8 * 1024 * 1024
"""Maximum that may wait for a reader; more is lost, which the capture says."""


class Capture:
    """Capture for one reader. ``sources`` are ports, segments and CAN buses. All records have simulated time,
    counted from the wall's at 0, so that they can be compared at any speed of the bench."""

    def __init__(self, sources: Sequence[Interface], clock: WallClock) -> None:
        self.sources = sources
        self._clock = clock
        self._epoch_ns = clock.epoch_ns
        self._writer: asyncio.StreamWriter | None = None
        self._lost = 0

    def begin(self, writer: asyncio.StreamWriter) -> None:
        """Send records to this writer from now on."""
        self._writer = writer
        writer.write(header(f"hil {__version__}", self.sources))

    def put(
        self, source: int, event: RecordKind, data: bytes = b"", comment: str = "", at_ns: int = -1
    ) -> None:
        """Write a record of a serial line; ``at_ns``: simulated time, else now."""
        sim_ns = self._clock.sim_ns(time.time_ns()) if at_ns < 0 else at_ns
        time_ns = self._epoch_ns + sim_ns
        if writer := self._writer_now(source, time_ns):
            writer.write(record(source, time_ns, event, data, comment))

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
        time_ns = self._epoch_ns + event.at_ns
        if writer := self._writer_now(source, time_ns, frames):
            writer.write(frame_record(source, time_ns, frames.packed(event), event.node))

    def _writer_now(
        self, source: int, time_ns: int, frames: FrameKind | None = None
    ) -> asyncio.StreamWriter | None:
        """Writer that has room, told what it has lost; None if what happens now is not for it."""
        writer = self._writer
        if writer is None or writer.is_closing():
            return None
        if writer.transport.get_write_buffer_size() > BACKLOG_BYTES:
            self._lost += 1
            return None
        if self._lost:
            writer.write(self._loss(source, time_ns, frames))
            self._lost = 0
        return writer

    def _loss(self, source: int, time_ns: int, frames: FrameKind | None) -> bytes:
        """Record of what was lost: of all sources, at the first that has something again."""
        why = f"the reader was too slow: {self._lost} lost"
        if frames:
            return frame_record(source, time_ns, frames.lost, why, self._lost)
        return record(source, time_ns, RecordKind.LOST, comment=why, lost=self._lost)
