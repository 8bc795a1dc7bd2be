"""Recordings drawn with characters."""

from hil.telemetry.recording import Recording
from hil.telemetry.ticks import round_ticks, shown_range

PANEL_HEIGHT = 14
Y_TICKS, COLUMNS_PER_TICK = 6, 12


def draw(recordings: dict[str, Recording], width: int, *, colour: bool, title: str = "") -> str:
    """Draw panels as ``Recording.panels``, a line for each signal and recording; width in characters."""
    import plotext as plt  # type: ignore[import-untyped]

    panels = next(iter(recordings.values())).panels()
    parts = []
    for i, signals in enumerate(panels):
        plt.clear_figure()
        plt.plotsize(width, PANEL_HEIGHT)
        if i == 0 and title:
            plt.title(title)
        for name, recording in recordings.items():
            prefix = f"{name} " if len(recordings) > 1 else ""
            for signal in signals:
                label = prefix + recording.label(signal)
                plt.plot(recording.at_s(), recording.column(signal), label=label, marker="braille")
        shown = [value for each in recordings.values() for signal in signals for value in each.column(signal)]
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
