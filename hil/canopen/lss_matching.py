"""How an LSS slave learns that a master means it.

Source: CiA 305 version 2.2.0, 4.4 (switch state selective), 4.7 (identification) and 4.8 (fastscan).
"""

from collections.abc import Callable, Sequence
from enum import Enum, auto

_ANYBODY = 0x80
_BITS = 32


class AddressMatch:
    """Messages of a series, each with a number to be compared. ``checks``: one for each message."""

    def __init__(self, checks: Sequence[Callable[[int], bool]]) -> None:
        self._checks = checks
        self._next = 0

    def reset(self) -> None:
        self._next = 0

    def take(self, step: int, number: int) -> bool:
        """Take a message; true if it is the last and all have matched, in their order."""
        if step == 0:
            self._next = 0
        is_right = step == self._next and self._checks[step](number)
        self._next = self._next + 1 if is_right else 0
        if self._next == len(self._checks):
            self._next = 0
            return True
        return False


def selection(address: Sequence[int]) -> AddressMatch:
    """Make the match of "switch state selective": all four numbers are those of the address."""
    return AddressMatch([number.__eq__ for number in address])


def identification(address: Sequence[int]) -> AddressMatch:
    """Make the match of "identify remote slave": vendor and product, then ranges of the other two."""
    vendor, product, revision, serial = address
    return AddressMatch(
        [vendor.__eq__, product.__eq__, revision.__ge__, revision.__le__, serial.__ge__, serial.__le__]
    )


class Scanned(Enum):
    """What a message of fastscan means to a slave."""

    OTHER = auto()
    FITS = auto()
    SELECTED = auto()


class FastScan:
    """Search for slaves bit by bit: the master asks, and who fits answers."""

    def __init__(self, address: Sequence[int]) -> None:
        self._address = address
        self._at = 0
        """Number of the address that is compared now, 0 to 3."""

    def reset(self) -> None:
        self._at = 0

    def take(self, number: int, bit: int, at: int, following: int) -> Scanned:
        """Take a message: bits of ``number`` from 31 down to ``bit`` are to be those of the address's number
        ``at``; once bit 0 fits too, ``following`` is the next. If that is an earlier one, the slave is
        selected."""
        if bit == _ANYBODY:
            self._at = 0
            return Scanned.FITS
        if at != self._at or max(at, following) >= len(self._address) or bit >= _BITS:
            return Scanned.OTHER
        if (number ^ self._address[at]) >> bit:
            return Scanned.OTHER
        if bit == 0:
            self._at = following
            if following < at:
                self._at = 0
                return Scanned.SELECTED
        return Scanned.FITS
