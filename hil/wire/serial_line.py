"""An asynchronous serial line seen by a receiver that may have been set to another baud rate.

All times are exact: the signal is computed in units of 1 / (2 * sent_baud * read_baud) seconds, in
which the edges of the sent bits and the middles of the read bits are whole numbers.
"""

from dataclasses import dataclass

from hil.vocab.line_format import EIGHT_N_1, LineFormat

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


_NS_PER_S = 10**9


@dataclass(frozen=True)
class Sampled:
    """One character as the receiver read it. A break reads as byte 0 with a framing error."""

    byte: int
    framing_error: bool
    """True if the line was low where the receiver looked for the stop bit."""
    offset_ns: int
    """Time of the character's start edge, counted from the first start edge, rounded down."""
    parity_error: bool = False
    """True if the parity bit was not that of the byte."""


def character_ns(n: int, baud: int, bits: int = EIGHT_N_1.bits) -> int:
    """Duration of ``n`` characters of so many bits (start and stop included), rounded down once."""
    return n * bits * _NS_PER_S // baud


def character_ends_ns(start_ns: int, count: int, baud: int, bits: int = EIGHT_N_1.bits) -> list[int]:
    """Times at which characters that stand back to back from ``start_ns`` on are complete."""
    one = bits * _NS_PER_S
    return [start_ns + all_ns // baud for all_ns in range(one, one * (count + 1), one)]


def resample(
    data: bytes,
    sent_baud: int,
    read_baud: int,
    line_format: LineFormat = EIGHT_N_1,
    read_format: LineFormat | None = None,
) -> list[Sampled]:
    """Read bytes that were sent back to back at ``sent_baud`` as a receiver at ``read_baud`` does, which
    expects ``read_format``, by default the sender's.

    One start bit, data bits (least significant first), parity if the format has it, stop bits, the line
    idle before and after. The receiver waits for a falling edge, and checks that the line is still low in the
    middle of the start bit. It takes each further bit in its middle, and looks for the next falling edge
    after it has sampled the first stop bit. A sample on an edge sees the level after the edge.

    Raises:
        ValueError: a baud rate is not positive.
    """
    if sent_baud <= 0 or read_baud <= 0:
        raise ValueError(f"baud rates must be positive, not {sent_baud} and {read_baud}")
    read_format = read_format or line_format
    if sent_baud == read_baud and read_format is line_format:
        bits = line_format.bits
        return [Sampled(byte, False, character_ns(n, sent_baud, bits)) for n, byte in enumerate(data)]
    return _sample(_levels(data, line_format), sent_baud, read_baud, read_format)


def _levels(data: bytes, line_format: LineFormat) -> bytes:
    """The line's level (0 or 1) in each bit time; one idle bit stands before the first start bit."""
    levels = bytearray([1])
    for byte in data:
        levels += bytes(line_format.levels(byte))
    return bytes(levels)


def _sample(levels: bytes, sent_baud: int, read_baud: int, line_format: LineFormat) -> list[Sampled]:
    sent_bit = 2 * read_baud
    half_read_bit = sent_baud
    data_bits = line_format.data_bits
    samples = line_format.bits - line_format.stop_bits + 1
    middles = [(2 * bit + 1) * half_read_bit for bit in range(samples)]
    last = len(levels) - 1  # a stop bit: the line stays at its level
    sampled = []
    now = -1  # the first start edge is at 0
    # levels[k + 1] begins at k * sent_bit, where the edge between levels[k] and levels[k + 1] is.
    while (edge := levels.find(b"\x01\x00", now // sent_bit + 1)) >= 0:
        start = edge * sent_bit
        bits = [levels[min((start + middle) // sent_bit + 1, last)] for middle in middles]
        if bits[0] == 1:  # too short for a start bit: the receiver takes it for a glitch
            now = start + middles[0]
            continue
        byte = sum(bit << place for place, bit in enumerate(bits[1 : 1 + data_bits]))
        is_odd = line_format.has_parity and bits[1 + data_bits] != line_format.parity_bit(byte)
        sampled.append(Sampled(byte, bits[-1] == 0, edge * _NS_PER_S // sent_baud, is_odd))
        now = start + middles[-1]
    return sampled
