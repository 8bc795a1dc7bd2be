def crc16(data: bytes) -> int:
    """CRC of a frame's bytes before it: x^16 + x^15 + x^2 + 1, least significant bit first, from 0xFFFF. On
    the line its low byte comes first (2.5.1.2)."""
