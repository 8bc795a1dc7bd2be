"""Packets of a line in words, as a page gets them: what silence completes, and what it does not."""

from typing import Any

import pytest

from hil.testing import Bench
from hil.vocab.segment import SegmentEvent
from hil.vocab.time import SimTimeNs
from hil.wire.packet_words import PacketWords

LATER_NS = 1_000_000_000
BOARDS = {"sac": {"stations": ["s1"]}, "modbus": {"modbus": {"units": {"s1": 1}}}}


def words(kind: str) -> PacketWords:
    """Words for a line of SACs or of Modbus RTU."""
    bench = Bench({"bench": "t", "devices": {"s1": {"profile": "sac"}}, "segments": {"bus0": BOARDS[kind]}})
    return PacketWords(bench.segment("bus0"))


def event(at_ns: int, data: bytes, *, is_damaged: bool = False) -> SegmentEvent:
    return SegmentEvent(SimTimeNs(at_ns), data, "bus0.m", is_damaged)


def told(items: Any) -> list[tuple[float, str, str | None]]:
    return [(item["at_s"], item["hex"], item["error"]) for item in items]


def test_a_packet_that_does_not_go_on_is_told_once_and_may_go_on() -> None:
    line = words("sac")
    assert line.say(event(5, b"\2\x56\1")) == []
    assert line.unfinished(4) == []
    [item] = line.unfinished(LATER_NS)
    assert told([item]) == [(5e-9, "025601", "unfinished")]
    assert item["by"] == "bus0.m"
    assert item["is_unfinished"]
    assert line.unfinished(2 * LATER_NS) == []
    assert line.say(event(LATER_NS, b"m9")) == []
    assert told(line.unfinished(2 * LATER_NS)) == [(5e-9, "0256016d39", "unfinished")]
    assert told(line.say(event(2 * LATER_NS, b"\3\0\2"))) == [(2.0, "0256016d390300", None)]
    assert told(line.unfinished(3 * LATER_NS)) == [(2.0, "02", "unfinished")]


def test_what_is_held_is_told_again_behind_what_was_damaged() -> None:
    line = words("sac")
    line.say(event(5, b"\2\x56"))
    assert len(line.unfinished(LATER_NS)) == 1
    assert told(line.say(event(LATER_NS, b"\xff", is_damaged=True))) == [(1.0, "ff", "bus0.m")]
    assert told(line.unfinished(2 * LATER_NS)) == [(5e-9, "0256", "unfinished")]
    line.start_again()
    assert line.unfinished(3 * LATER_NS) == []


@pytest.mark.parametrize("data", [b"\1\3\0\0\0\2\xc4\x0b", b"\1\3"])
def test_silence_ends_what_it_can(data: bytes) -> None:
    line = words("modbus")
    assert line.say(event(5, data)) == []
    [item] = line.silence(LATER_NS)
    assert item["hex"] == data.hex()
    assert line.unfinished(LATER_NS) == []
