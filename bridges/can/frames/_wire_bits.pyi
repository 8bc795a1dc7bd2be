from bridges.can.frames.can_frame import CanFrame

def plain_bits(frame: CanFrame) -> bytes:
    """Bits of a frame that ``check`` has found good, from its start to its CRC, before stuffing: a byte of 0
    or 1 for each. 34 for a standard frame, 54 for an extended one, and 8 for each byte."""

def wire_bits(frame: CanFrame) -> bytes:
    """Bits of a frame as its sender drives them: stuffed up to the CRC's end, then the delimiter of the CRC,
    the slot for the acknowledgement and its delimiter, and the seven of the end of frame."""

def crc15(bits: bytes) -> int:
    """CRC of bits (x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1, from 0), each a byte of 0 or 1."""
