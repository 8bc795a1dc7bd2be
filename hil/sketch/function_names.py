"""Functions of a program by their addresses, with names as they stand in its source.

Source: Itanium C++ ABI, 5.1 (mangled names); DS40002061, 12.4 (interrupt vectors), with the names that
avr-libc has for them.
"""

import re
from bisect import bisect_right
from collections.abc import Sequence

from hil.sketch.elf_file import Symbol

FUNCTION = "function"
VECTOR_NAMES = (
    *("RESET", "INT0", "INT1", "PCINT0", "PCINT1", "PCINT2", "WDT", "TIMER2_COMPA", "TIMER2_COMPB"),
    *("TIMER2_OVF", "TIMER1_CAPT", "TIMER1_COMPA", "TIMER1_COMPB", "TIMER1_OVF", "TIMER0_COMPA"),
    *("TIMER0_COMPB", "TIMER0_OVF", "SPI_STC", "USART_RX", "USART_UDRE", "USART_TX", "ADC", "EE_READY"),
    *("ANALOG_COMP", "TWI", "SPM_READY"),
)
"""Interrupt vectors by their numbers."""
VECTOR_BYTES = 4
_VECTOR = re.compile(r"__vector_(\d+)")
_NAME = re.compile(r"(\d+)")
_CLONE = re.compile(r"\.(?:constprop|part|isra|lto_priv|cold)\b.*")


def source_name(symbol: str) -> str:
    """Name of a function in the source, with (): of a mangled one without its parameters; an interrupt's as
    in ``ISR(TIMER1_COMPA_vect)``. A name that is mangled in a way not known stays as it is."""
    symbol = _CLONE.sub("", symbol)
    if (vector := _VECTOR.fullmatch(symbol)) and int(vector[1]) < len(VECTOR_NAMES):
        return f"ISR({VECTOR_NAMES[int(vector[1])]}_vect)"
    if not symbol.startswith("_Z"):
        return f"{symbol}()"
    rest = symbol[2:].removeprefix("L").removeprefix("N").lstrip("rVKL")
    parts = list[str]()
    while found := _NAME.match(rest):
        begin = found.end()
        end = begin + int(found[1])
        parts.append(rest[begin:end])
        rest = rest[end:].removeprefix("L")
    if parts and rest[:2] in ("C1", "C2", "D1", "D2"):
        parts.append(parts[-1] if rest[0] == "C" else f"~{parts[-1]}")
    return f"{'::'.join(parts)}()" if parts else symbol


class Functions:
    """Functions of a program. ``symbols``: of any kind, in any order."""

    def __init__(self, symbols: Sequence[Symbol]) -> None:
        rows = sorted((each for each in symbols if each.kind == FUNCTION), key=lambda each: each.address)
        found = {each.address: each for each in reversed(rows)}  # the first of several names of one
        self.all = [found[address] for address in sorted(found)]
        """Functions in the order of their addresses."""
        self.starts = sorted(found)
        """Byte addresses of their first instructions."""

    def at(self, address: int) -> Symbol | None:
        """Function that has an instruction at this byte address; one whose size is not known reaches to the
        next."""
        place = bisect_right(self.starts, address) - 1
        if place < 0:
            return None
        found = self.all[place]
        return found if not found.size or address < found.address + found.size else None

    def name_at(self, address: int) -> str:
        """Name of the function at an address; empty: none is known."""
        found = self.at(address)
        return source_name(found.name) if found else ""
