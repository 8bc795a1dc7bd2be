"""Format of the characters on a serial line: a start bit, data bits, parity or none, stop bits."""

import re
from functools import lru_cache
from typing import Literal, cast

from hil.vocab.late_dataclass import dataclass

DATA_BITS = 8
Parity = Literal["N", "E", "O", "M", "S"]


@dataclass(frozen=True)
class LineFormat:
    """Format of a line's characters. ``name``: as people write it, ``8E1``; ``parity``: N none, E even,
    O odd, M always 1, S always 0."""

    name: str
    parity: Parity
    stop_bits: int
    bits: int
    """Number of bits of a character, start and stop included."""
    data_bits: int = DATA_BITS

    @property
    def has_parity(self) -> bool:
        return self.parity != "N"

    def is_like(self, other: "LineFormat") -> bool:
        """True if a receiver of the other format reads all that is sent in this one: stop bits may differ."""
        return self is other or (self.parity, self.data_bits) == (other.parity, other.data_bits)

    def parity_bit(self, byte: int) -> int:
        """Parity bit of a byte, in a format that has one."""
        if self.parity in "MS":
            return int(self.parity == "M")
        return (byte & (1 << self.data_bits) - 1).bit_count() & 1 ^ (self.parity == "O")

    def levels(self, byte: int) -> tuple[int, ...]:
        """Level of the line in each bit of a character, the start bit first."""
        parity = (self.parity_bit(byte),) if self.has_parity else ()
        return (0, *(byte >> bit & 1 for bit in range(self.data_bits)), *parity, *(1,) * self.stop_bits)


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
"""Formats of segments."""


@lru_cache
def format_named(name: str) -> LineFormat | None:
    """Format of a client's line by its name, as ``7E1``: 5 to 8 data bits, 1 or 2 stop bits; None: it has
    another form."""
    if name in FORMATS:
        return FORMATS[name]
    if not re.fullmatch("[5-8][NEOMS][12]", name, re.ASCII):
        return None
    data_bits, parity, stop_bits = int(name[0]), cast(Parity, name[1]), int(name[2])
    bits = 1 + data_bits + (parity != "N") + stop_bits
    return LineFormat(name, parity, stop_bits, bits, data_bits)
