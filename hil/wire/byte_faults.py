"""Byte faults of a bad line: bits flipped, bytes lost, doubled or delayed. Pure and seeded."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from hil.vocab.faults import Fault
from hil.vocab.time import NS_PER_MS
from hil.wire._byte_faults import Draws

_MASK = (1 << 64) - 1


class Chance:
    """A stream of numbers that depends on its seed alone (splitmix64, Steele et al. 2014)."""

    def __init__(self, seed: int) -> None:
        self._state = seed & _MASK

    def below(self, probability: float) -> bool:
        """True with this probability."""
        return self.bits() < probability * 2.0**64

    def bits(self) -> int:
        """Next 64 bits of the stream."""
        self._state = (self._state + 0x9E3779B97F4A7C15) & _MASK
        z = self._state
        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & _MASK
        z = (z ^ z >> 27) * 0x94D049BB133111EB & _MASK
        return z ^ z >> 31


@dataclass(frozen=True)
class ByteFault:
    """Probabilities for each byte, except ``bit_error_rate``, which is for each of its eight bits."""

    bit_error_rate: float = 0.0
    drop_rate: float = 0.0
    duplicate_rate: float = 0.0
    delay_rate: float = 0.0
    delay_ns: int = 0
    """Delay of a byte. Bytes behind it keep their order."""


class ByteFaults(Draws):
    """One direction of a line under faults; ``changed_bytes`` counts the bytes that did not come through as
    they were.

    ``apply(data)`` gives pieces with the time (ns) by which each is late; none may overtake the one before. A
    byte's fate depends on how many came before it, not on the pieces they come in.
    """

    def __init__(self, fault: ByteFault, seed: int) -> None:
        rates = (fault.bit_error_rate, fault.drop_rate, fault.duplicate_rate, fault.delay_rate)
        flip, drop, duplicate, delay = (math.ceil(rate * 2.0**64) for rate in rates)
        super().__init__(seed & _MASK, flip, drop, duplicate, delay, fault.delay_ns)


def byte_faults(fault: Fault) -> ByteFaults:
    """Make a fault of the layer ``byte`` (``hil.vocab.faults``) from its seed."""
    rate = fault.number("rate")
    delay_ns = round(float(fault.parameters.get("delay_ms", 0)) * NS_PER_MS)
    effect = {
        "byte_flip": ByteFault(bit_error_rate=rate),
        "byte_drop": ByteFault(drop_rate=rate),
        "byte_duplicate": ByteFault(duplicate_rate=rate),
        "byte_delay": ByteFault(delay_rate=rate, delay_ns=delay_ns),
    }[fault.kind]
    return ByteFaults(effect, int(fault.number("seed")))


def apply_all(faults: Iterable[ByteFaults], data: bytes) -> list[tuple[int, bytes]]:
    """Apply several faults, one after the other; as ``ByteFaults.apply``."""
    pieces = [(0, data)]
    for fault in faults:
        pieces = [
            (delay_ns + more_ns, part) for delay_ns, piece in pieces for more_ns, part in fault.apply(piece)
        ]
    return pieces
