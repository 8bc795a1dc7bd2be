"""Points of a plan: set-points over time, and its steps, to see a run before anything moves."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from hil.runs.plan import Move, Phrase, Plan
from hil.runs.run_document import ACTIONS, Step
from hil.vocab.path import DEG_PER_S, PathPiece
from hil.vocab.time import NS_PER_S

MOST_STEPS = 300
"""Maximum number of steps that are told."""
LOOKS = 4
"""Number of looks at a set-point in each interval, besides those at the beginnings of its pieces."""
_AXES_NAMED = 4


def plan_points(plan: Plan, most: int) -> dict[str, Any]:
    """Points of a plan, at most so many: of each interval an axis's smallest and largest set-point.

    Axes with ramps of their own are drawn as if they had their speed at once, and waits take no time:
    ``is_exact`` says whether there are any.
    """
    laid = list(_laid(plan))
    total_ns = sum(length_ns for length_ns, _ in laid)
    intervals = max(most // (2 * max(len(plan.run.axes), 1)), 2)
    steps = list(_steps(plan, [length_ns for length_ns, _ in laid]))
    return {
        "duration_s": round(total_ns / NS_PER_S, 6),
        "is_exact": not any(phrase.awaited or phrase.wait for phrase in plan.phrases),
        "axes": {
            name: _points((piece for _, ways in laid for piece in ways[name]), total_ns, intervals)
            for name in plan.run.axes
        },
        "steps": steps[:MOST_STEPS],
        "steps_left_out": max(len(steps) - MOST_STEPS, 0),
    }


def _laid(plan: Plan) -> Iterator[tuple[int, Mapping[str, Sequence[PathPiece]]]]:
    """Each phrase's length, and the ways of all axes through it."""
    at_deg = {name: plan.axes[name].position_deg for name in plan.run.axes}
    for phrase in plan.phrases:
        moved = {event.axis for event in phrase.events if isinstance(event, Move)}
        ways: dict[str, Sequence[PathPiece]] = {
            **{name: _own_ramps(phrase, name, at_deg[name]) for name in moved},
            **phrase.paths,
        }
        length_ns = max(
            [phrase.duration_ns, *(sum(each.duration_ns for each in way) for way in ways.values())]
        )
        whole: dict[str, Sequence[PathPiece]] = {}
        for name, before_deg in at_deg.items():
            way = ways.get(name, ())
            after_deg = way[-1].after(way[-1].duration_ns)[0] if way else before_deg
            left_ns = length_ns - sum(piece.duration_ns for piece in way)
            whole[name] = [*way, PathPiece(left_ns, after_deg)]
        at_deg = {name: way[-1].r for name, way in whole.items()}
        yield length_ns, whole


def _own_ramps(phrase: Phrase, name: str, at_deg: float) -> list[PathPiece]:
    """Way of an axis with ramps of its own, as if it had its speed at once."""
    pieces: list[PathPiece] = []
    gone_ns = 0
    for event in phrase.events:
        if not isinstance(event, Move) or event.axis != name:
            continue
        if event.at_ns > gone_ns:
            pieces.append(PathPiece(event.at_ns - gone_ns, at_deg))
        way_deg = event.position_deg - at_deg
        per_s = event.velocity_rpm * DEG_PER_S
        lasts_ns = round(abs(way_deg) / per_s * NS_PER_S)
        pieces.append(PathPiece(lasts_ns, at_deg, per_s if way_deg > 0 else -per_s))
        gone_ns = max(event.at_ns, gone_ns) + lasts_ns
        at_deg = event.position_deg
    return pieces


def _points(way: Iterable[PathPiece], total_ns: int, intervals: int) -> dict[str, list[float]]:
    """Smallest and largest set-point of each interval, in the order of their times."""
    step_ns = max(total_ns // (intervals * LOOKS), 1)
    found: list[tuple[int, float]] = []
    low = high = last = (0, 0.0)
    interval = -1
    begin_ns = 0

    def put(point: tuple[int, float]) -> None:
        if len(found) > 1 and found[-1][1] == found[-2][1] == point[1]:
            found[-1] = point
        elif not found or found[-1] != point:
            found.append(point)

    def close() -> None:
        for point in sorted((low, high)) if interval >= 0 else ():
            put(point)

    for piece in way:
        looks = range(-begin_ns % step_ns, piece.duration_ns, step_ns)
        for into_ns in looks if looks and looks[0] == 0 else (0, *looks):
            last = (begin_ns + into_ns, piece.after(into_ns)[0])
            now = min(last[0] * intervals // max(total_ns, 1), intervals - 1)
            if now != interval:
                close()
                interval, low, high = now, last, last
            low = last if last[1] < low[1] else low
            high = last if last[1] > high[1] else high
        begin_ns += piece.duration_ns
        last = (begin_ns, piece.after(piece.duration_ns)[0])
    close()
    put(last)
    return {
        "at_s": [round(at_ns / NS_PER_S, 4) for at_ns, _ in found],
        "position_deg": [round(deg, 3) for _, deg in found],
    }


def _steps(plan: Plan, lengths_ns: Sequence[int]) -> Iterator[list[Any]]:
    """Steps in the order in which they are done: from, to, its number from 1, what it does."""
    begin_ns = 0
    for phrase, length_ns in zip(plan.phrases, lengths_ns, strict=True):
        ends_ns = [at_ns for at_ns, _ in phrase.marks[1:]] + [length_ns]
        for (at_ns, index), end_ns in zip(phrase.marks, ends_ns, strict=True) if phrase.marks else ():
            span_s = ((begin_ns + each_ns) / NS_PER_S for each_ns in (at_ns, end_ns))
            yield [*(round(each_s, 4) for each_s in span_s), index + 1, said(plan.run.steps[index])]
        begin_ns += length_ns


def said(step: Step) -> str:
    """Words of what a step does."""
    for name in ACTIONS:
        value = getattr(step, name)
        if value is None:
            continue
        if name == "wait_until":
            return f"wait for {value.axis} {value.field}"
        if isinstance(value, Mapping):
            listed = [f"{axis} {angle:g}" for axis, angle in value.items()]
            rest = f" and {len(listed) - _AXES_NAMED} more" if len(listed) > _AXES_NAMED else ""
            return f"{name} {', '.join(listed[:_AXES_NAMED])}{rest}"
        return f"{name} {value:g}" if isinstance(value, float) else str(name)
    return step.label or ""
