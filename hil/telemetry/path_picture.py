"""Picture of a path that was asked for, and of the one that axes followed: needs the extra ``plot``
(matplotlib)."""

import math
from collections.abc import Sequence
from io import BytesIO
from typing import Any

from hil.telemetry.picture import check_can_draw

Places = Sequence[Sequence[float]]
"""Positions of a machine's axes, one place after the other."""
_WORST: dict[str, Any] = {"markersize": 9, "markerfacecolor": "none", "markeredgecolor": "#7c2d12"}
"""Mark of the place where the deviation is largest."""
PATH_IN, LEAST_IN, OTHER_IN = 5.4, 1.6, 1.8
"""Height of the path's panel, at most and at least, and of each other, in inches."""
MOST_POINTS = 100_000
"""Maximum number of points of a line; of more, some are left out."""


def path_drawn(
    asked: Places,
    followed: Places,
    letters: str,
    suffix: str,
    *,
    course: Sequence[tuple[float, float]] = (),
    rapids: Sequence[bool] = (),
    title: str = "",
    notes: str = "",
) -> bytes:
    """Draw both paths from above, and from the sides where the third axis moves, as bytes; ``letters`` names
    the axes in the places' order, ``suffix`` is one of ``hil.telemetry.picture.FORMATS``. ``course``: way
    along the path asked for and distance from it, of each place that was followed: drawn below, for it is too
    small to be seen above, and the worst place is marked. ``rapids``: whether a rapid leads to each place of
    the path asked for; those are dashed.

    Raises:
        PictureError: matplotlib is not installed.
    """
    check_can_draw()
    from matplotlib.figure import Figure

    views = _views(asked, letters)
    others = len(views) - 1 + bool(course)
    above_in = min(max(PATH_IN * _shape(asked, views[0]), LEAST_IN), PATH_IN)
    figure = Figure(figsize=(8, above_in + 1.1 + OTHER_IN * others), layout="constrained")
    panels = figure.subplots(
        1 + others, 1, squeeze=False, gridspec_kw={"height_ratios": [above_in] + [1.3] * others}
    )[:, 0]
    worst = max(range(len(course)), key=lambda number: course[number][1], default=None)
    fed, rapid = parted(asked, rapids)
    lines: list[tuple[Places, str, dict[str, Any]]] = [
        (fed, "asked for", {"linewidth": 2.4, "color": "#9db8d9"}),
        (
            followed[:: max(len(followed) // MOST_POINTS, 1)],
            "followed",
            {"linewidth": 0.9, "color": "#c2410c"},
        ),
    ]
    if rapid:
        dashed = {"linewidth": 2.4, "color": "#9db8d9", "linestyle": (0, (5, 4))}
        lines.insert(1, (rapid, "rapid", dashed))
    for panel, (across, up) in zip(panels, views, strict=False):
        for places, name, style in lines:
            panel.plot([p[across] for p in places], [p[up] for p in places], label=name, **style)
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
        panels[-1].set_ylim(0, max(course[worst][1] * 1.15, 1e-6))
        panels[-1].grid(alpha=0.3)
    if title:
        figure.suptitle(title)
    if notes:
        panels[0].set_title(notes, fontsize="small")
    data = BytesIO()
    figure.savefig(data, format=suffix.removeprefix("."), dpi=110)
    return data.getvalue()


def _shape(places: Places, view: tuple[int, int]) -> float:
    """Height of a view by its width."""
    across, up = ([place[axis] for place in places] for axis in view)
    wide, high = max(across) - min(across), max(up) - min(up)
    return high / wide if wide else math.inf


def parted(places: Places, rapids: Sequence[bool]) -> tuple[Places, Places]:
    """Part a path into what is fed and what is rapid, with gaps between the pieces."""
    if not any(rapids):
        return places[:: max(len(places) // MOST_POINTS, 1)], ()
    gap = (math.nan,) * len(places[0])
    parts: tuple[list[Sequence[float]], list[Sequence[float]]] = ([], [])
    for before, place, is_rapid in zip(places, places[1:], rapids[1:], strict=False):
        line = parts[is_rapid]
        if not line or line[-1] is not before:
            line += (gap, before)
        line.append(place)
    return parts


def _views(asked: Places, letters: str) -> list[tuple[int, int]]:
    """Pairs of axes: X and Y, and those with Z where it moves; of other machines the first two."""
    at = {letter: number for number, letter in enumerate(letters)}
    views = [(at["x"], at["y"])] if {"x", "y"} <= at.keys() else [(0, min(1, len(letters) - 1))]
    if (z := at.get("z")) is not None and len({round(place[z], 6) for place in asked}) > 1:
        views += [(at[each], z) for each in "xy" if each in at]
    return list(dict.fromkeys(views))


def _named(letter: str) -> str:
    return f"{letter.upper()} [{'deg' if letter in 'abc' else 'mm'}]"
