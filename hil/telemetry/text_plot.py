"""Recordings drawn with characters."""

from hil.telemetry.recording import Recording

PANEL_HEIGHT = 14


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
        if i == len(panels) - 1:
            plt.xlabel("s")
        parts.append(plt.build() if colour else plt.uncolorize(plt.build()))
    return "\n".join(parts)
