"""Recordings drawn with characters."""

import math
from collections.abc import Sequence

from hil.telemetry.recording import Recording, shared_panels

PANEL_HEIGHT = 14
Y_TICKS, COLUMNS_PER_TICK = 6, 12


def draw(recordings: dict[str, Recording], width: int, *, colour: bool, title: str = "") -> str:
    """Draw panels as ``Recording.panels``, a line for each signal and recording; width in characters."""
    import plotext as plt  # type: ignore[import-untyped]

    panels = shared_panels(recordings.values())
    parts = []
    for i, signals in enumerate(panels):
        plt.clear_figure()
        plt.plotsize(width, PANEL_HEIGHT)
        if i == 0 and title:
            plt.title(title)
        for name, recording in recordings.items():
            prefix = f"{name} " if len(recordings) > 1 else ""
            for signal in filter(recording.has, signals):
                label = prefix + recording.label(signal)
                plt.plot(recording.at_s(), recording.column(signal), label=label, marker="braille")
        shown = [
            value
            for each in recordings.values()
            for signal in filter(each.has, signals)
            for value in each.column(signal)
        ]
        low, high = shown_range(shown)
        plt.ylim(low, high)
        plt.yticks(*round_ticks(low, high, Y_TICKS))
        first_s, last_s = shown_range([at_s for each in recordings.values() for at_s in each.at_s()])
        plt.xlim(first_s, last_s)
        plt.xticks(*round_ticks(first_s, last_s, max(2, width // COLUMNS_PER_TICK)))
        if i == len(panels) - 1:
            plt.xlabel("s")
        parts.append(plt.build() if colour else plt.uncolorize(plt.build()))
    return "\n".join(parts)


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
