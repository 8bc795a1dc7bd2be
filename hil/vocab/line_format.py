"""Format of the characters on a serial line: a start bit, eight data bits, parity or none, stop bits."""

from dataclasses import dataclass
from typing import Literal

DATA_BITS = 8


@dataclass(frozen=True)
class LineFormat:
    """Format of a line's characters. ``name``: as people write it, ``8E1``; ``parity``: N none, E even,
    O odd."""

    name: str
    parity: Literal["N", "E", "O"]
    stop_bits: int
    bits: int
    """Number of bits of a character, start and stop included."""

    @property
    def has_parity(self) -> bool:
        return self.parity != "N"

    def parity_bit(self, byte: int) -> int:
        """Parity bit of a byte, in a format that has one."""
        return byte.bit_count() & 1 ^ (self.parity == "O")

    def levels(self, byte: int) -> tuple[int, ...]:
        """Level of the line in each bit of a character, the start bit first."""
        parity = (self.parity_bit(byte),) if self.has_parity else ()
        return (0, *(byte >> bit & 1 for bit in range(DATA_BITS)), *parity, *(1,) * self.stop_bits)


EIGHT_N_1 = LineFormat("8N1", "N", 1, 10)
"""Format of boards' UARTs, and of a line for which nobody says another."""
EVEN = "8E1"
FORMATS = {
    each.name: each
    for each in (
        EIGHT_N_1,
        LineFormat(EVEN, "E", 1, 11),
        LineFormat("8O1", "O", 1, 11),
        LineFormat("8N2", "N", 2, 11),
    )
}
