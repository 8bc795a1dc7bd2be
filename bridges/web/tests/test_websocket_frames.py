"""Frames of WebSockets: what has to be refused, in whatever pieces it comes, and long messages."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.web.websocket_frames import FRAGMENT_BYTES, FrameCheck, fragments

REFUSED = b"\x83\x80\0\0\0\0"
MASK = b"\x11\x22\x33\x44"


def frame(first: int, payload: bytes = b"", form: int | None = None, *, is_masked: bool = True) -> bytes:
    """Frame of a client. ``form``: 126 or 127 for a longer length than needed."""
    if form is None:
        form = len(payload) if len(payload) < 126 else 126 if len(payload) < 1 << 16 else 127
    head = bytes((first, form | 0x80 * is_masked))
    if form >= 126:
        head += struct.pack(">H" if form == 126 else ">Q", len(payload))
    if is_masked:
        head += MASK
        payload = bytes(byte ^ MASK[at % 4] for at, byte in enumerate(payload))
    return head + payload


def closing(code: int) -> bytes:
    return frame(0x88, struct.pack(">H", code) + b"why")


GOOD = (
    frame(0x81, b"hello"),
    frame(0x82, bytes(200)),
    frame(0x82, bytes(1 << 16)),
    frame(0x01, b"") + frame(0x89, b"ping") + frame(0x00, b"b") + frame(0x80, b"c"),
    frame(0x88),
    *(closing(code) for code in (1000, 1001, 1003, 1007, 1011, 3000, 4999)),
)
BAD = (
    frame(0x81, b"hello", is_masked=False),
    frame(0x88, is_masked=False),
    frame(0x81, b"short", 126),
    frame(0x81, b"short", 127),
    frame(0x80, b"nothing to go on with"),
    frame(0x01, b"") + frame(0x81, b"another"),
    b"\x82\xff" + b"\xff" * 8 + MASK,
    *(closing(code) for code in (0, 999, 1004, 1005, 1006, 1015, 2999, 5000, 65535)),
)


def passed(data: bytes, sizes: list[int]) -> bytes:
    check, found, at = FrameCheck(), b"", 0
    for size in [*sizes, len(data)]:
        found += check.passed(data[at : at + size])
        at += size
    return found


SIZES = st.lists(st.integers(1, 9), max_size=30)


@given(st.lists(st.sampled_from(GOOD), max_size=4), SIZES)
def test_frames_as_browsers_send_them_pass_unchanged(frames: list[bytes], sizes: list[int]) -> None:
    assert passed(b"".join(frames), sizes) == b"".join(frames)


@pytest.mark.parametrize("bad", BAD)
@given(st.sampled_from(GOOD), SIZES)
def test_a_wrong_frame_is_refused_and_all_behind_it(bad: bytes, good: bytes, sizes: list[int]) -> None:
    found = passed(good + bad + good, sizes)
    assert found.startswith(good)
    assert found.endswith(REFUSED)
    assert found.count(REFUSED) == 1
    assert len(found) < len(good + bad) + len(REFUSED)


def test_a_long_text_is_sent_in_fragments() -> None:
    parts = (b"a" * 10, b"b" * (FRAGMENT_BYTES + 300), b"", b"c")
    frames = list(fragments(parts))
    assert [each[0] for each in frames] == [0x01, 0x00, 0x00, 0x00, 0x80]
    assert [each[1] & 0x80 for each in frames] == [0] * 5
    assert b"".join((frames[0][2:], frames[1][10:], frames[2][4:], frames[3][2:])) == b"".join(parts)
