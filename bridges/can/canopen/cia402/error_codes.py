"""Error codes of a drive (603Fh and EMCY) and the bits of the error register (1001h) that go with them.

Source: IEC 61800-7-201:2015, table of error codes; CiA 301, 7.2.7.1. From FF00h on they are hil's own.
"""

from collections.abc import Mapping
from enum import IntEnum

_GENERIC, _COMMUNICATION, _PROFILE, _OWN = 0x01, 0x10, 0x20, 0x80


class DriveError(IntEnum):
    """Error code; ``ABOUT`` says what each means."""

    COMMUNICATION = 0x8100
    HEARTBEAT = 0x8130
    BUS_OFF = 0x8140
    FOLLOWING = 0x8611
    SYNC = 0x8700
    LOOP_OFF = 0xFF01
    REFUSED = 0xFF02


ABOUT: Mapping[DriveError, str] = {
    DriveError.COMMUNICATION: "the node was stopped while operation was enabled",
    DriveError.HEARTBEAT: "the master's heartbeat or guarding timed out; the node itself sends it",
    DriveError.BUS_OFF: "the node was bus-off; the node itself sends it",
    DriveError.FOLLOWING: "the shaft was too far from the set-point for too long (6065h, 6066h)",
    DriveError.SYNC: "no SYNC came for three periods of 60C2h, at least 50 ms, in a cyclic mode",
    DriveError.LOOP_OFF: "the board switched its loop off by itself",
    DriveError.REFUSED: "the board refused what the drive told it",
}
"""Texts of error codes."""
_BITS = {
    DriveError.COMMUNICATION: _GENERIC | _COMMUNICATION,
    DriveError.FOLLOWING: _GENERIC | _PROFILE,
    DriveError.SYNC: _GENERIC | _COMMUNICATION,
    DriveError.LOOP_OFF: _GENERIC | _OWN,
    DriveError.REFUSED: _GENERIC | _OWN,
}
LOST = {
    "heartbeat": DriveError.HEARTBEAT,
    "guarding": DriveError.HEARTBEAT,
    "bus-off": DriveError.BUS_OFF,
}
"""Errors by what a node says that it has lost."""
TOLD_BY_NODE = frozenset(LOST.values())
"""Errors of which the node itself sends EMCY."""


def register_bits(code: int) -> int:
    """Bits of the error register for an error code; of a board's own fault bit 0."""
    return _BITS[DriveError(code)] if code in _BITS else _GENERIC
