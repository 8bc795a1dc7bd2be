"""Captures whose reader is too slow, and the times of what they have."""

import time
from types import SimpleNamespace
from typing import Any

import pytest

from bridges.can.frames.socketcan import FRAMES_LOST, CanError, unpack
from hil.live.captures import BACKLOG_BYTES, Capture
from hil.live.core_thread import WallClock
from hil.vocab.segment import SegmentEvent
from hil.vocab.time import SimTimeNs
from hil.vocab.wire import FrameKind
from hil.wire.pcapng import LINKTYPE_CAN_SOCKETCAN, Interface, RecordKind, read


class SlowWriter:
    """Writer whose reader takes nothing while ``waiting`` is large."""

    def __init__(self) -> None:
        self.got = b""
        self.waiting = 0
        self.transport = self

    def write(self, data: bytes) -> None:
        self.got += data

    def is_closing(self) -> bool:
        return False

    def get_write_buffer_size(self) -> int:
        return self.waiting


def test_how_many_were_lost_is_told_by_the_next_record() -> None:
    frames = FrameKind(lambda event: bytes(16), dict, LINKTYPE_CAN_SOCKETCAN, FRAMES_LOST)
    for line in (Interface("bus0", "sac"), Interface("can0", link=LINKTYPE_CAN_SOCKETCAN)):
        writer: Any = SlowWriter()
        no_bench: Any = None
        clock = WallClock(no_bench, 1.0, 0)
        capture = Capture([Interface("bus0", "sac"), line], clock)
        capture.begin(writer)
        writer.waiting = BACKLOG_BYTES + 1
        for at_ns in range(3):
            capture.heard(0, SegmentEvent(SimTimeNs(at_ns), b"x", "s1"))
        writer.waiting = 0
        for at_ns in (7, 8):
            if line.is_can:
                capture.carried(1, frames, SimpleNamespace(at_ns=at_ns, node="m1"))
            else:
                capture.put(1, RecordKind.RX, b"y", at_ns=at_ns)
        lost, *rest = read(writer.got)
        assert lost.lost == 3
        assert lost.comment == "the reader was too slow: 3 lost"
        if line.is_can:
            assert unpack(lost.data) == CanError("frames lost")
        else:
            assert lost.event == RecordKind.LOST
        assert [each.lost for each in rest] == [0, 0]


def test_ports_and_segments_have_the_same_time_at_any_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    no_bench: Any = None
    writer: Any = SlowWriter()
    capture = Capture([Interface("m1", "raw"), Interface("bus0", "sac")], WallClock(no_bench, 20.0, 10**18))
    capture.begin(writer)
    monkeypatch.setattr(time, "time_ns", lambda: 10**18 + 7 * 10**9)
    capture.passed(0, "board", b"p")
    capture.heard(1, SegmentEvent(SimTimeNs(140 * 10**9), b"x", "s1"))
    assert [each.at_ns - 10**18 for each in read(writer.got)] == [140 * 10**9] * 2
