"""Figures beside the limits that they exceed, for refusals."""

DIGITS = 4
"""Number of digits of a figure that is far from its limit."""
MOST_DIGITS = 17
"""Number of digits that tell any two floats apart."""


def seen_over(value: float, limit: float, digits: int = DIGITS) -> str:
    """Format a figure with so many digits that it is not the limit as ``:g`` shows that: 20.4 beside 20."""
    told = float(f"{limit:g}")
    for count in range(digits, MOST_DIGITS):
        shown = f"{value:.{count}g}"
        if float(shown) != told and (float(shown) > told) == (value > told):
            break
    return f"{value:.{max(count, 6)}g}" if "e" in shown else shown
