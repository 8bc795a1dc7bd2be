"""Pins of a microcontroller as a firmware drives them, and the pulses that its timers make.

This is the seam between a sketch and the wires of a bench: whatever runs on the processor, a level is given
at the present simulated time, and a timer's pulses at times that are exact to the nanosecond.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol


class Pulses(NamedTuple):
    """Pulses one after the other. Each rises ``period_ns`` after the one before, the first one after what was
    before it, and is high for ``high_ns``, which is less."""

    number: int
    period_ns: int
    high_ns: int


class Pins(Protocol):
    """Pins of a board by name, as in ``D6``. After power-up all are inputs. An unknown name is a KeyError."""

    def write(self, pin: str, level: int) -> None:
        """Drive a pin to a level, 0 or 1, from now on: it is an output."""

    def let_go(self, pin: str) -> None:
        """Make a pin an input again."""

    def read(self, pin: str) -> int:
        """Level of a pin now, 0 or 1: the board's own if it drives it."""

    def pulse(self, pin: str, rows: Sequence[Pulses]) -> None:
        """Begin a train of pulses at a pin, instead of the one before, which ends at once; no rows: none.
        When the last pulse has ended, the interrupt ``pulses_ended`` comes."""

    @property
    def pulses_left(self) -> int:
        """Pulses of the train that are to come."""
