"""Frames as text in the notation of can-utils, as ``str`` of a frame writes it: ``123#0011``, ``0000CAFE#R``.

Source: the manual page of cansend in can-utils.
"""

import re

from hil.wire.can.can_frame import DATA_MAX, EXTENDED_ID_MAX, STANDARD_ID_MAX, CanFrame

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
        raise ValueError(f"{digits[:40]!r} is no data, two digits for each of 0 to {DATA_MAX} bytes")
    return bytes.fromhex(digits)
