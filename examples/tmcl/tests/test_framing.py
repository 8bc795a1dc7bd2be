"""Frames on a line: however bytes come, in words, and whose they are."""

import pytest

from hil.vocab.time import FOREVER, SimTimeNs
from tmcl_bus.frames import BROKEN_OFF_NS, Command, Reply, Request, Status
from tmcl_bus.framing import TMCL_FRAMING

MOVE = Request(1, Command.MVP, 0, 0, 51_200).encode()
MOVED = Reply(2, 1, Status.OK, Command.MVP, 51_200).encode()
VERSION = Request(1, Command.GFV, 0, 0, 0).encode()
STREAM = MOVE + MOVED + Request(7, Command.GAP, 1, 0, 0).encode() + VERSION + b"\x020000V002"


def said(stream: bytes, size: int = 1) -> list[str]:
    splitter, items = TMCL_FRAMING.splitter(), []
    for start in range(0, len(stream), size):
        items += splitter.burst(stream[start : start + size], SimTimeNs(start * 1000), 9600).items
    items += splitter.silence(SimTimeNs(FOREVER - 1))
    assert b"".join(item.raw for item in items) == stream
    return [TMCL_FRAMING.text(item) for item in items]


@pytest.mark.parametrize("size", [1, 2, 5, 9, 100])
def test_frames_in_words_however_they_come(size: int) -> None:
    assert said(STREAM, size) == [
        "to 1: MVP ABS 0 51200",
        "from 1: ok MVP 51200",
        "to 7: GAP 1 0 (actual position)",
        "to 1: GFV 0",
        "from 1: 0000V002",
    ]


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        (Request(3, Command.ROL, 0, 0, 500).encode(), "to 3: ROL 0 500"),
        (Request(3, Command.MVP, 1, 0, -7).encode(), "to 3: MVP REL 0 -7"),
        (Request(3, Command.SAP, 4, 0, 1000).encode(), "to 3: SAP 4 0 1000 (maximum speed)"),
        (Request(3, Command.SIO, 1, 2, 1).encode(), "to 3: SIO 1 2 1"),
        (Request(3, Command.MST, 0, 0, 0).encode(), "to 3: MST 0"),
        (Request(3, 77, 1, 2, 3).encode(), "to 3: command 77 type 1 motor 2 value 3"),
        (MOVE[:-1] + b"\x00", "to 1: MVP ABS 0 51200  checksum 00 is wrong"),
        (MOVE[:4], "malformed (too short): 01 04 00 00"),
    ],
)
def test_requests_in_words(raw: bytes, words: str) -> None:
    assert said(raw) == [words]


@pytest.mark.parametrize(
    ("status", "words"),
    [
        (Status.WRONG_CHECKSUM, "from 1: wrong checksum MVP"),
        (Status.INVALID_VALUE, "from 1: invalid value MVP"),
        (Status.NOT_AVAILABLE, "from 1: not available MVP"),
    ],
)
def test_refusals_in_words(status: Status, words: str) -> None:
    assert said(MOVE + Reply(2, 1, status, Command.MVP, 0).encode(), 9)[1] == words


def test_whom_a_burst_concerns_and_who_speaks() -> None:
    splitter = TMCL_FRAMING.splitter()
    asked = splitter.burst(MOVE, SimTimeNs(0), 9600)
    assert asked.addresses == {1}
    answered = splitter.burst(MOVED, SimTimeNs(10**8), 9600)
    assert answered.addresses == {2}
    parties = [TMCL_FRAMING.parties(item) for item in (*asked.items, *answered.items)]
    assert parties == [(None, 1), (1, 2)]
    assert splitter.burst(MOVE[:3], SimTimeNs(2 * 10**8), 9600).addresses is None
    assert splitter.copy().burst(MOVE[3:], SimTimeNs(2 * 10**8 + 4 * 10**6), 9600).addresses is None


def test_a_silence_breaks_a_frame_off() -> None:
    splitter = TMCL_FRAMING.splitter()
    over_ns = splitter.burst(MOVE[:3], SimTimeNs(0), 9600).over_ns
    assert over_ns == 3 * 10**10 // 9600 + BROKEN_OFF_NS
    assert splitter.silence(SimTimeNs(over_ns - 1)) == ()
    assert [item.fault for item in splitter.silence(over_ns)] == ["too short"]
    assert splitter.pending == b""
