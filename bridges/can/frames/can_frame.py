"""A frame of classic CAN: as a value, and as text.

The text is the notation of can-utils, as ``str`` of a frame writes it: ``123#0011``, ``0000CAFE#R``. Source:
the manual page of cansend in can-utils.
"""

import re
from typing import NamedTuple

STANDARD_ID_MAX, EXTENDED_ID_MAX = 0x7FF, 0x1FFF_FFFF
DATA_MAX = 8


class CanFrame(NamedTuple):
    """Data frame or, with ``is_remote``, the request for one. ``check`` says whether a frame can be sent."""

    id: int
    """Identifier, 11 bits; 29 with ``is_extended``. The lowest is the most urgent."""
    data: bytes = b""
    is_extended: bool = False
    is_remote: bool = False
    remote_dlc: int = 0
    """Number of bytes that a remote frame asks for."""

    @property
    def dlc(self) -> int:
        """Data length code, 0 to 8."""
        return self.remote_dlc if self.is_remote else len(self.data)

    def __str__(self) -> str:
        """Format as in ``123#0011`` and ``0000CAFE#R2``, the notation of can-utils' ``cansend``."""
        name = f"{self.id:08X}" if self.is_extended else f"{self.id:03X}"
        return f"{name}#R{self.remote_dlc or ''}" if self.is_remote else f"{name}#{self.data.hex().upper()}"


def check(frame: CanFrame) -> None:
    """Check that a frame can be sent.

    Raises:
        ValueError: an identifier out of range, more than 8 bytes, or a remote frame with data.
    """
    highest, bits = (EXTENDED_ID_MAX, 29) if frame.is_extended else (STANDARD_ID_MAX, 11)
    if not 0 <= frame.id <= highest:
        raise ValueError(f"identifier {frame.id:#x}; with {bits} bits it is 0 to {highest:#x}")
    if len(frame.data) > DATA_MAX or not 0 <= frame.remote_dlc <= DATA_MAX:
        raise ValueError(f"{max(len(frame.data), frame.remote_dlc)} bytes; a frame has 0 to {DATA_MAX}")
    if frame.is_remote and frame.data:
        raise ValueError("a remote frame has no data")
    if frame.remote_dlc and not frame.is_remote:
        raise ValueError("remote_dlc is of a remote frame; a data frame has as many bytes as data")


def urgency(frame: CanFrame) -> int:
    """Number by which frames are arbitrated: of several the lowest wins.

    It has 32 bits, those of the frame from the identifier to RTR. So of one base identifier a data frame is
    before a remote one, and both are before an extended one.
    """
    if frame.is_extended:
        base, rest = divmod(frame.id, 1 << 18)
        return base << 21 | 3 << 19 | rest << 1 | frame.is_remote
    return frame.id << 21 | frame.is_remote << 20


_FORM = re.compile("([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#([0-9A-Fa-f#R]*)")
_REMOTE = re.compile("R[0-8]?")
REMEDY = "write three or eight digits, # and two digits for each byte, or R: 123#0011, 0000CAFE#R2"


def parse_frame(text: str) -> CanFrame:
    """Parse a frame.

    Raises:
        ValueError: it is none of classic CAN.
    """
    found = _FORM.fullmatch(text)
    if not found:
        raise ValueError(f"{text[:40]!r} is no frame; {REMEDY}")
    digits, rest = found.groups()
    identifier, is_extended = int(digits, 16), len(digits) == 8
    if identifier > (EXTENDED_ID_MAX if is_extended else STANDARD_ID_MAX):
        raise ValueError(
            f"identifier {digits} has more than 29 bits"
            if is_extended
            else f"identifier {digits} has more than 11 bits; write 8 digits for 29"
        )
    if "R" in rest:
        if not _REMOTE.fullmatch(rest):
            raise ValueError(f"{rest!r} is no remote frame, R or R0 to R8")
        return CanFrame(identifier, b"", is_extended, True, int(rest[1:] or 0))
    return CanFrame(identifier, parse_data(rest), is_extended)


def parse_data(digits: str) -> bytes:
    """Parse the bytes of a data frame.

    Raises:
        ValueError: it is none of classic CAN.
    """
    if digits.startswith("#"):
        raise ValueError("a frame of CAN FD; this reads classic CAN")
    if "#" in digits or len(digits) % 2 or len(digits) > 2 * DATA_MAX:
        raise ValueError(f"{digits[:40]!r} is no data; write two digits for each of 0 to {DATA_MAX} bytes")
    return bytes.fromhex(digits)
