"""Picture of a path that was asked for, and of the one that axes followed: needs the extra ``plot``
(matplotlib)."""

from collections.abc import Sequence
from io import BytesIO
from typing import Any

from hil.telemetry.picture import check_can_draw

Places = Sequence[Sequence[float]]
"""Positions of a machine's axes, one place after the other."""
_WORST: dict[str, Any] = {"markersize": 9, "markerfacecolor": "none", "markeredgecolor": "#7c2d12"}
"""Mark of the place where the deviation is largest."""
MOST_POINTS = 100_000
"""Maximum number of points of a line; of more, some are left out."""


def path_drawn(
    asked: Places,
    followed: Places,
    letters: str,
    suffix: str,
    *,
    course: Sequence[tuple[float, float]] = (),
    title: str = "",
    notes: str = "",
) -> bytes:
    """Draw both paths from above, and from the sides where the third axis moves, as bytes; ``letters`` names
    the axes in the places' order, ``suffix`` is one of ``hil.telemetry.picture.FORMATS``. ``course``: way
    along the path asked for and distance from it, of each place that was followed: drawn below, for it is too
    small to be seen above, and the worst place is marked.

    Raises:
        PictureError: matplotlib is not installed.
    """
    check_can_draw()
    from matplotlib.figure import Figure

    views = _views(asked, letters)
    others = len(views) - 1 + bool(course)
    figure = Figure(figsize=(8, 6 + 1.8 * others), layout="constrained")
    panels = figure.subplots(
        1 + others, 1, squeeze=False, gridspec_kw={"height_ratios": [4.5] + [1.3] * others}
    )[:, 0]
    worst = max(range(len(course)), key=lambda number: course[number][1], default=None)
    for panel, (across, up) in zip(panels, views, strict=False):
        for places, name, style in (
            (asked, "asked for", {"linewidth": 2.4, "color": "#9db8d9"}),
            (followed, "followed", {"linewidth": 0.9, "color": "#c2410c"}),
        ):
            kept = places[:: max(len(places) // MOST_POINTS, 1)]
            panel.plot([p[across] for p in kept], [p[up] for p in kept], label=name, **style)
        if worst is not None:
            place = followed[worst]
            panel.plot([place[across]], [place[up]], "o", **_WORST, label="largest deviation")
        panel.set_xlabel(_named(letters[across]))
        panel.set_ylabel(_named(letters[up]))
        panel.grid(alpha=0.3)
    panels[0].set_aspect("equal", adjustable="datalim")
    panels[0].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="small", frameon=False)
    if worst is not None:
        kept = course[:: max(len(course) // MOST_POINTS, 1)]
        panels[-1].plot([way for way, _ in kept], [off for _, off in kept], linewidth=0.9, color="#c2410c")
        panels[-1].plot(*([each] for each in course[worst]), "o", **_WORST)
        panels[-1].set_xlabel("way along the path asked for [mm]")
        panels[-1].set_ylabel("deviation [mm]")
        panels[-1].set_ylim(bottom=0)
        panels[-1].grid(alpha=0.3)
    if title:
        figure.suptitle(title)
    if notes:
        panels[0].set_title(notes, fontsize="small")
    data = BytesIO()
    figure.savefig(data, format=suffix.removeprefix("."), dpi=110)
    return data.getvalue()


def _views(asked: Places, letters: str) -> list[tuple[int, int]]:
    """Pairs of axes: X and Y, and those with Z where it moves; of other machines the first two."""
    at = {letter: number for number, letter in enumerate(letters)}
    views = [(at["x"], at["y"])] if {"x", "y"} <= at.keys() else [(0, min(1, len(letters) - 1))]
    if (z := at.get("z")) is not None and len({round(place[z], 6) for place in asked}) > 1:
        views += [(at[each], z) for each in "xy" if each in at]
    return list(dict.fromkeys(views))


def _named(letter: str) -> str:
    return f"{letter.upper()} [{'deg' if letter in 'abc' else 'mm'}]"
