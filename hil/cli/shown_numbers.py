"""Numbers for people: 0 for what is as good as 0, and no sign before it."""

DUST = 1e-12
"""Magnitude below which a field's value is 0, whatever its unit: what decays and sums leave."""
EXACT = 1 << 53
"""Magnitude up to which a float has each whole number, as one of nanoseconds."""


def shown_number(value: float | None) -> str:
    """Format a field's value; None is one that is not told."""
    if value is None:
        return "-"
    if abs(value) < DUST:
        return "0"
    is_whole = float(value).is_integer() and abs(value) < EXACT
    return str(round(value)) if is_whole else f"{value:.10g}"


def fixed(value: float | None, decimals: int) -> str:
    """Format a value with so many decimals; None is one that is not told."""
    return "-" if value is None else f"{round(value, decimals) + 0.0:.{decimals}f}"
