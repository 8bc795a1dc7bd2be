"""Bits, lengths and CRC of frames, against a naive model and published figures."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from bridges.can.frames._wire_bits import crc15, plain_bits, wire_bits
from bridges.can.frames.can_frame import CanFrame, urgency
from bridges.can.frames.frame_length import INTERMISSION_BITS, frame_bits, longest_bits, shortest_bits

TABLE = yaml.safe_load((Path(__file__).parent / "frames_on_the_wire.yaml").read_text())


@st.composite
def frames(draw: st.DrawFn) -> CanFrame:
    is_extended = draw(st.booleans())
    number = draw(st.integers(0, 0x1FFFFFFF if is_extended else 0x7FF))
    if draw(st.booleans()):
        return CanFrame(number, b"", is_extended, True, draw(st.integers(0, 8)))
    byte = st.one_of(st.integers(0, 255), st.sampled_from((0, 255, 0x0F, 0x78, 0xE1)))
    return CanFrame(number, bytes(draw(st.lists(byte, max_size=8))), is_extended)


def naive_plain(frame: CanFrame) -> str:
    """Bits of a frame as text: its fields, and the remainder of a division of polynomials."""
    remote = "1" if frame.is_remote else "0"
    if frame.is_extended:
        digits = f"{frame.id:029b}"
        text = f"0{digits[:11]}11{digits[11:]}{remote}00"
    else:
        text = f"0{frame.id:011b}{remote}00"
    text += f"{frame.dlc:04b}" + "".join(f"{byte:08b}" for byte in frame.data)
    value = int(text, 2) << 15
    for place in range(len(text) + 14, 14, -1):
        value ^= (0b1100010110011001 << place - 15) * (value >> place & 1)
    return f"{text}{value:015b}"


def naive_stuffed(text: str) -> str:
    """Stuff as text: behind five bits of one kind, counted again from a stuff bit on, stands the other."""
    out = ""
    since = 0
    for bit in text:
        out += bit
        if len(out) - since >= 5 and out[-5:] in ("00000", "11111"):
            since = len(out)
            out += "1" if bit == "0" else "0"
    return out


def text(bits: bytes) -> str:
    return "".join(map(str, bits))


@pytest.mark.parametrize("row", TABLE, ids=lambda row: str(row["frame"]))
def test_frames_of_the_table(row: dict[str, Any]) -> None:
    fields = row["frame"]
    frame = CanFrame(**fields | {"data": bytes.fromhex(fields.get("data", ""))})
    stuffed = row["bits"].replace(" ", "").replace("[", "").replace("]", "")
    assert text(wire_bits(frame)) == stuffed + 10 * "1"
    assert row["bits"].count("[") == frame_bits(frame) - shortest_bits(
        len(frame.data), is_extended=frame.is_extended
    )


@pytest.mark.thorough
@pytest.mark.long
@settings(max_examples=1000, deadline=None)
@given(frames())
def test_bits_are_those_of_the_naive_model(frame: CanFrame) -> None:
    assert text(plain_bits(frame)) == naive_plain(frame)
    assert text(wire_bits(frame)) == naive_stuffed(naive_plain(frame)) + 10 * "1"


@pytest.mark.long
@settings(max_examples=1000, deadline=None)
@given(frames())
def test_lengths_are_within_the_published_bounds(frame: CanFrame) -> None:
    bits = frame_bits(frame)
    size = len(frame.data)
    assert shortest_bits(size, is_extended=frame.is_extended) <= bits
    assert bits <= longest_bits(size, is_extended=frame.is_extended)
    assert "000000" not in text(wire_bits(frame))
    assert "111111" not in text(wire_bits(frame))[:-10]


@pytest.mark.parametrize("size", range(9))
def test_the_longest_are_those_of_davis(size: int) -> None:
    """Table of the paper, by its equations 2 and 3: 55 + 10 s and 80 + 10 s bits, with the space behind."""
    assert longest_bits(size, is_extended=False) + INTERMISSION_BITS == 55 + 10 * size
    assert longest_bits(size, is_extended=True) + INTERMISSION_BITS == 80 + 10 * size


def test_the_crc_has_its_published_check_value() -> None:
    """CRC-15/CAN of the catalogue of parametrised CRC algorithms (reveng), of the text 123456789."""
    bits = bytes(int(bit) for byte in b"123456789" for bit in f"{byte:08b}")
    assert crc15(bits) == 0x059E
    assert crc15(b"") == 0


@pytest.mark.long
@settings(max_examples=300, deadline=None)
@given(frames())
def test_the_crc_of_bits_with_their_crc_is_none(frame: CanFrame) -> None:
    assert crc15(plain_bits(frame)) == 0


@pytest.mark.long
@settings(max_examples=500, deadline=None)
@given(frames(), frames())
def test_urgency_is_the_order_of_the_wire(first: CanFrame, second: CanFrame) -> None:
    """Of two frames the one is before the other whose bits are dominant where they differ first."""
    a, b = wire_bits(first), wire_bits(second)
    if urgency(first) != urgency(second):
        assert (urgency(first) < urgency(second)) == (a < b)


def test_frames_have_a_notation() -> None:
    assert str(CanFrame(0x12, b"\xab")) == "012#AB"
    assert str(CanFrame(0x12, is_extended=True, is_remote=True, remote_dlc=3)) == "00000012#R3"
    assert str(CanFrame(0x12, is_remote=True)) == "012#R"
