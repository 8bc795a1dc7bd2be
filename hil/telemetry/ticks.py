"""Ticks of drawings at round numbers."""

import math
from collections.abc import Sequence

_ROUND = (1.0, 2.0, 2.5, 5.0)
FLAT = 1e-9
"""Range, in any field's unit, below which a signal stands still."""


def shown_range(values: Sequence[float]) -> tuple[float, float]:
    """Range that a drawing of these values shows: theirs, and one unit around a signal that stands still."""
    finite = [value for value in values if math.isfinite(value)] or [0.0]
    low, high = min(finite), max(finite)
    if high - low > max(FLAT, FLAT * max(abs(low), abs(high))):
        return low, high
    return low - 1.0, high + 1.0


def round_ticks(low: float, high: float, most: int) -> tuple[list[float], list[str]]:
    """Round numbers from ``low`` to ``high`` and their texts, ``most`` at most: multiples of 1, 2, 2.5 or 5
    times a power of ten. ``high`` is above ``low``, ``most`` at least 2."""
    power = math.floor(math.log10((high - low) / most))
    steps = (factor * 10.0**n for n in (power, power + 1, power + 2) for factor in _ROUND)
    for step in steps:
        first, last = math.ceil(low / step - FLAT), math.floor(high / step + FLAT)
        if last - first < most:
            break
    decimals = max(0, f"{step:e}".startswith("2.5") - math.floor(math.log10(step) + FLAT))
    ticks = [number * step for number in range(first, last + 1)]
    return ticks, [f"{tick:.{decimals}f}" for tick in ticks]
