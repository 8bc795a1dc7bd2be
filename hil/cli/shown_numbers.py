"""Numbers for people: 0 for what is as good as 0, and no sign before it."""

from struct import Struct

_FLOAT = Struct("f")
DUST = 1e-12
"""Magnitude below which a field's value is 0, whatever its unit: what decays and sums leave."""
EXACT = 1 << 53
"""Magnitude up to which a float has each whole number, as one of nanoseconds."""


def counted(count: int, noun: str) -> str:
    """Format a number of things, as in ``1 device`` and ``2 devices``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def shown_number(value: float | None, *, is_short: bool = False) -> str:
    """Format a field's value; None is one that is not told. ``is_short``: it is a float of 32 bits, and only
    the digits that tell it from its neighbours count."""
    if value is None:
        return "-"
    if abs(value) < DUST:
        return "0"
    is_whole = float(value).is_integer() and abs(value) < EXACT
    if is_whole or not is_short:
        return str(round(value)) if is_whole else f"{value:.10g}"
    digits = (f"{value:.{count}g}" for count in range(1, 10))
    return next((each for each in digits if _same_float(float(each), value)), f"{value:.10g}")


def _same_float(one: float, other: float) -> bool:
    return _FLOAT.pack(one) == _FLOAT.pack(other)


def fixed(value: float | None, decimals: int) -> str:
    """Format a value with so many decimals; None is one that is not told."""
    return "-" if value is None else f"{round(value, decimals) + 0.0:.{decimals}f}"
