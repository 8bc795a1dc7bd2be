"""Frames of TMCL: nine bytes each way, the last of which is the sum of the others.

A request: module's address, command, type, motor or bank, value. A reply: host's address, module's address,
status, command, value. Values have 32 bits, the high byte first, and are signed where that makes sense.

Sources: "TMCM-6110 TMCL Firmware V1.19 Manual", 5.6.39 (GFV), "TMCM-6212 TMCL Firmware Manual" V1.11 (a
reply as bytes); numbers of commands and statuses as the maker's pytrinamic 0.2.26 has them.
"""

from dataclasses import dataclass
from enum import IntEnum
from struct import Struct

FRAME_BYTES = 9
BROKEN_OFF_NS = 5_000_000
"""Silence within a frame after which a module takes the next byte as the first of another one: chosen."""
HOST = 2
"""Address to which modules reply, as they are delivered."""
MODULES = range(1, 256)
"""Addresses that a module may have."""
FULL_STEPS = 200
"""Full steps in a turn of a motor."""
_LAYOUT = Struct(">BBBBi")


class Command(IntEnum):
    """Commands that these modules know."""

    ROR = 1
    ROL = 2
    MST = 3
    MVP = 4
    SAP = 5
    GAP = 6
    SGP = 9
    GGP = 10
    SIO = 14
    GIO = 15
    GFV = 136


class Status(IntEnum):
    """Status of a reply."""

    WRONG_CHECKSUM = 1
    INVALID_COMMAND = 2
    WRONG_TYPE = 3
    INVALID_VALUE = 4
    EEPROM_LOCKED = 5
    NOT_AVAILABLE = 6
    OK = 100
    LOADED = 101


class Move(IntEnum):
    """Types of MVP."""

    ABS = 0
    REL = 1
    COORD = 2


STATUSES = frozenset(map(int, Status))
AS_TEXT = 0
"""Type of GFV whose reply is a text: the host's address and eight characters, without a sum."""


@dataclass(frozen=True)
class Request:
    """Request to a module."""

    module: int
    command: int
    type: int
    motor: int
    value: int

    def encode(self) -> bytes:
        return _summed(_LAYOUT.pack(self.module, self.command, self.type, self.motor, self.value))


@dataclass(frozen=True)
class Reply:
    """Reply of a module to a host."""

    host: int
    module: int
    status: int
    command: int
    value: int

    def encode(self) -> bytes:
        return _summed(_LAYOUT.pack(self.host, self.module, self.status, self.command, self.value))


def request_of(raw: bytes) -> Request:
    """Read the nine bytes of a request, whatever their sum is."""
    return Request(*_LAYOUT.unpack_from(raw))


def reply_of(raw: bytes) -> Reply:
    """Read the nine bytes of a reply, whatever their sum is."""
    return Reply(*_LAYOUT.unpack_from(raw))


def has_right_sum(raw: bytes) -> bool:
    return sum(raw[:-1]) & 0xFF == raw[-1]


def asks_for_text(raw: bytes) -> bool:
    """True for a request whose reply is a text."""
    return raw[1] == Command.GFV and raw[2] == AS_TEXT


def is_reply(asked: bytes, raw: bytes) -> bool:
    """True if a frame can be the reply to the one before it."""
    if asks_for_text(asked) and raw[1:].isascii() and raw[1:].decode("ascii").isprintable():
        return True
    return raw[1] == asked[0] and raw[3] == asked[1] and raw[2] in STATUSES


def _summed(body: bytes) -> bytes:
    return body + bytes((sum(body) & 0xFF,))
