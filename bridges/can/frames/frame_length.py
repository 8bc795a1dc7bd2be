"""Lengths of CAN frames on the wire, in bits."""

from bridges.can.frames._wire_bits import wire_bits
from bridges.can.frames.can_frame import CanFrame

TAIL_BITS = 10
"""Delimiter of the CRC, slot and delimiter of the acknowledgement, seven bits of the end of frame."""
INTERMISSION_BITS = 3
"""Space between two frames at least."""


def frame_bits(frame: CanFrame) -> int:
    """Length from the start of frame to the end of frame, stuff bits included, without the space behind."""
    return len(wire_bits(frame))


def shortest_bits(data_bytes: int, *, is_extended: bool) -> int:
    """Length of a frame without a stuff bit."""
    return (54 if is_extended else 34) + 8 * data_bytes + TAIL_BITS


def longest_bits(data_bytes: int, *, is_extended: bool) -> int:
    """Length of a frame with as many stuff bits as there can be: one behind the first five bits and then one
    for every four.

    Source: Davis, Burns, Bril and Lukkien, Controller Area Network (CAN) schedulability analysis: Refuted,
    revisited and revised, 2007, equation 1; theirs has the three bits of the space behind it too.
    """
    stuffed = (54 if is_extended else 34) + 8 * data_bytes
    return stuffed + TAIL_BITS + (stuffed - 1) // 4
