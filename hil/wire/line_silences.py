"""Silences on a serial line that bound what is sent in one piece: those of Modbus RTU (2.5.1.1), by which
lines of bytes alone go, too. Up to 19200 baud they follow the speed; above it they are fixed."""

FIXED_ABOVE_BAUD = 19200
"""Speed above which both silences are fixed (2.5.1.1)."""
FIXED_GAP_NS, FIXED_SILENCE_NS = 750_000, 1_750_000
_TENTH_S_NS = 10**8


def gap_ns(baud: int, bits: int = 10) -> int:
    """Longest silence within a frame (t1.5), rounded down. ``bits``: of a character."""
    return FIXED_GAP_NS if baud > FIXED_ABOVE_BAUD else 15 * bits * _TENTH_S_NS // baud


def silence_ns(baud: int, bits: int = 10) -> int:
    """Shortest silence between frames (t3.5), rounded down. ``bits``: of a character."""
    return FIXED_SILENCE_NS if baud > FIXED_ABOVE_BAUD else 35 * bits * _TENTH_S_NS // baud
