"""Captures whose records wait for a batch: the same bytes, later."""

import asyncio
import time
from typing import Any

import pytest

from hil.live.captures import BACKLOG_BYTES, BATCH, Capture
from hil.live.core_thread import WallClock
from hil.live.tests.test_capture_losses import SlowWriter
from hil.vocab.segment import SegmentEvent
from hil.vocab.time import SimTimeNs
from hil.wire.pcapng import Interface, RecordKind

NO_BENCH: Any = None


def captured(loop: asyncio.AbstractEventLoop | None) -> tuple[Capture, SlowWriter]:
    capture = Capture([Interface("m1", "raw"), Interface("bus0", "sac")], WallClock(NO_BENCH, 1.0, 10**18))
    writer: Any = SlowWriter()
    capture.begin(writer, loop)
    return capture, writer


def filled(capture: Capture, times: int) -> None:
    for n in range(times):
        capture.passed(0, "board", b"p" * (n % 5))
        capture.heard(1, SegmentEvent(SimTimeNs(n), b"x", "s1"))


def test_a_batch_has_the_bytes_of_its_records(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "time_ns", lambda: 10**18 + 7 * 10**9)
    at_once, told = captured(None)
    filled(at_once, 3 * BATCH)

    async def main() -> None:
        capture, writer = captured(asyncio.get_running_loop())
        head = writer.got
        filled(capture, 3 * BATCH)
        assert writer.got == head  # nothing before others had their turn
        await asyncio.sleep(0)
        assert writer.got == told.got
        capture.put(0, RecordKind.RX, b"y", at_ns=7)
        at_once.put(0, RecordKind.RX, b"y", at_ns=7)
        capture.flush()  # as at the end
        assert writer.got == told.got

    asyncio.run(main())


def test_what_waits_counts_as_backlog() -> None:
    async def main() -> None:
        capture, writer = captured(asyncio.get_running_loop())
        for _ in range(9):
            capture.put(0, RecordKind.RX, bytes(BACKLOG_BYTES // 8), at_ns=7)
        capture.flush()
        assert len(writer.got) < BACKLOG_BYTES * 1.2
        capture.put(0, RecordKind.RX, b"y", at_ns=7)
        capture.flush()
        assert b"the reader was too slow: " in writer.got

    asyncio.run(main())
