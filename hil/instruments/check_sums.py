"""Check sums at the ends of commands and answers."""

from functools import reduce
from operator import xor
from typing import NamedTuple

XOR, SUM, CRC16 = "xor", "sum", "crc16"
_POLYNOMIAL = 0xA001
"""CRC-16 of Modbus, low bit first. Source: Modbus over serial line 1.02, 6.2.2."""


class CheckSum(NamedTuple):
    """Check sum: ``xor`` or ``sum`` of all bytes, 8 bits, or ``crc16``, Modbus's, low byte first. ``is_hex``:
    digits in base 16, in capital letters, else bytes."""

    kind: str
    is_hex: bool

    @property
    def length(self) -> int:
        """Number of characters."""
        return (2 if self.kind == CRC16 else 1) * (2 if self.is_hex else 1)

    def of(self, text: str) -> str:
        """Check sum of a text, each character a byte."""
        data = text.encode("latin-1", "replace")
        if self.kind == CRC16:
            found = _crc16(data).to_bytes(2, "little")
        else:
            found = bytes((reduce(xor, data, 0) if self.kind == XOR else sum(data) & 0xFF,))
        return found.hex().upper() if self.is_hex else found.decode("latin-1")

    def checked(self, text: str) -> str | None:
        """Text without its check sum; None: that is wrong, or is not there."""
        body, given = text[: -self.length], text[-self.length :]
        given = given.upper() if self.is_hex else given
        return body if len(text) >= self.length and self.of(body) == given else None


def _crc16(data: bytes) -> int:
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ _POLYNOMIAL if crc & 1 else crc >> 1
    return crc
