"""Recordings drawn as a picture: needs the extra ``plot`` (matplotlib)."""

from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import Any

from hil.telemetry.recording import Recording, shared_panels

FORMATS = (".png", ".svg", ".pdf")
_QUANTITIES = {
    "deg": "angle", "rpm": "velocity", "Nm": "torque", "A": "current", "V": "voltage", "J": "energy",
    "Hz": "frequency", "degC": "temperature", "step": "steps", "pulse": "pulses", "turn": "turns",
    "count": "counts", "ms": "time", "us": "time",
}  # fmt: skip
"""Words for the values of a panel, by their unit."""
_LEGEND_CHARACTERS = 26
"""Width of a legend's words, beside the data."""


class PictureError(Exception):
    """Error of a picture that cannot be made: ``str(error)`` says why and what to do."""


def check_can_draw() -> None:
    """Check that pictures can be made here. Raises PictureError: matplotlib is not installed."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise PictureError(
            "pictures need matplotlib, which is not installed:"
            " pip install 'hil-motion[plot]', or name a file .csv"
        ) from None


def draw(recordings: dict[str, Recording], path: Path, title: str = "", notes: str = "") -> None:
    """Draw panels as ``Recording.panels``, one line for each signal and recording; the format by the suffix.

    Raises:
        PictureError: matplotlib is not installed, the suffix is none of ``FORMATS``, or it cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise PictureError(f"{path}: write a name that ends in {', '.join(FORMATS)}")
    data = drawn(recordings, suffix, title, notes)
    try:
        path.write_bytes(data)
    except OSError as error:
        raise PictureError(f"{path}: {error.strerror}") from error


def _quantity(recordings: dict[str, Recording], signals: list[str]) -> str:
    """Words for a panel's values, with their unit: those of its signal, if it has one alone."""
    recording = next(each for each in recordings.values() if each.has(signals[0]))
    unit = recording.unit(signals[0])
    if len(signals) == 1:
        words = recording.meaning(signals[0])
        words = words if len(words) <= _LEGEND_CHARACTERS else _QUANTITIES.get(unit, "value")
    else:
        words = _QUANTITIES.get(unit, "value")
    return f"{words} [{unit}]" if unit else words


def _legend(prefix: str, recording: Recording, signal: str) -> str:
    """Name of a line with its unit, and below it what it is."""
    if prefix:
        return prefix + recording.label(signal)
    return "\n".join([recording.label(signal), *wrap(recording.meaning(signal), _LEGEND_CHARACTERS)])


def drawn(recordings: dict[str, Recording], suffix: str, title: str = "", notes: str = "") -> bytes:
    """Draw as ``draw`` into bytes, for a caller who writes files by other means; ``suffix`` is one of
    ``FORMATS``.

    Raises:
        PictureError: matplotlib is not installed.
    """
    check_can_draw()
    from matplotlib.figure import Figure

    panels = shared_panels(recordings.values())
    figure = Figure(figsize=(10, 1.2 + 2.2 * len(panels)), layout="constrained")
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for panel, signals in zip(axes, panels, strict=True):
        for number, (name, recording) in enumerate(recordings.items()):
            prefix = f"{name}: " if len(recordings) > 1 else ""
            for signal in filter(recording.has, signals):
                # A set-point is commanded: drawn thin and broken, so that what follows it stands out.
                style: dict[str, Any] = {"linewidth": 1.4}
                if signal == "r":
                    style = {"linestyle": "--", "linewidth": 1.0}
                if len(recordings) > 1:
                    style["color"] = f"C{number}"  # one colour for each recording
                panel.plot(
                    recording.at_s(),
                    recording.column(signal),
                    label=_legend(prefix, recording, signal),
                    **style,
                )
        panel.grid(alpha=0.3)
        panel.ticklabel_format(axis="y", useOffset=False)
        panel.set_ylabel(_quantity(recordings, signals))
        panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="small", frameon=False)
    axes[-1].set_xlabel("simulated time [s]")
    if title:
        figure.suptitle(title)
    if notes:
        axes[0].set_title(notes, fontsize="small")
    data = BytesIO()
    figure.savefig(data, format=suffix.removeprefix("."), dpi=120)
    return data.getvalue()
