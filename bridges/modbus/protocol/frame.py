"""Frames of Modbus RTU: address, function, data, CRC; and the silences that bound them.

A frame has at most 256 bytes, and no mark of its end: it ends where the line is silent for at least 3.5
characters. A silence of more than 1.5 characters within it makes it no frame. Up to 19200 baud these follow
the speed; above it they are fixed (2.5.1.1). A character has ten bits, or eleven with parity, which is the
standard's default.
"""

from dataclasses import dataclass

from bridges.modbus.protocol._crc16 import crc16

ADDRESSES = range(1, 248)
"""Addresses of nodes; those above are reserved (2.2)."""
TO_ALL = 0
FRAME_BYTES_MAX = 256
FRAME_BYTES_MIN = 4
"""Address, function and CRC."""
DATA_MAX = FRAME_BYTES_MAX - FRAME_BYTES_MIN


def encode(address: int, function: int, data: bytes = b"") -> bytes:
    """Encode a frame, with its CRC.

    Raises:
        ValueError: an address or a function that is no byte, or more data than fits.
    """
    if not 0 <= address <= 255 or not 0 <= function <= 255:
        raise ValueError(f"address and function are 0 to 255, not {address} and {function}")
    if len(data) > DATA_MAX:
        raise ValueError(f"{len(data)} bytes of data; a frame has at most {DATA_MAX}")
    body = bytes((address, function)) + data
    return body + crc16(body).to_bytes(2, "little")


@dataclass(frozen=True)
class Frame:
    """Bytes between two silences, with the form of a frame: of 4 to 256, none of them late."""

    at_ns: int
    """Time at which its first start bit began."""
    raw: bytes
    asked = b""
    """Frame that it answers; empty: it is a question, or nobody knows the question."""
    is_packet = True
    origin = None
    """Sender of the frame, which it does not tell: an answer has the address of the node that gives it, as
    the question had."""

    def as_answer(self, asked: bytes) -> "Frame":
        """The same as the answer to a frame."""
        object.__setattr__(self, "asked", asked)  # no field of the class, which costs each frame its time
        return self

    @property
    def address(self) -> int:
        return self.raw[0]

    @property
    def function(self) -> int:
        return self.raw[1]

    @property
    def data(self) -> bytes:
        return self.raw[2:-2]

    @property
    def fault(self) -> str:
        # The CRC of bytes with their CRC behind them, low byte first, is 0.
        return "CRC" if crc16(self.raw) else ""


@dataclass(frozen=True)
class Malformed:
    """Bytes between two silences that are no frame. ``fault`` is ``gap``, ``too short`` or ``too long``; what
    is too long comes in pieces of at most 256 bytes."""

    at_ns: int
    """Time at which its first start bit began."""
    raw: bytes
    fault: str
    is_packet = False
    origin = None
