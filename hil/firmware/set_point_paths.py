"""Paths of a set-point: their duration, their value at a time, and the way to rest or to a target."""

from collections.abc import Sequence
from math import sqrt

from hil.vocab.path import Path, PathPiece
from hil.vocab.time import NS_PER_S


def length_ns(path: Sequence[PathPiece]) -> int:
    """Duration of a path."""
    return sum(piece.duration_ns for piece in path)


def at(path: Sequence[PathPiece], into_ns: int) -> tuple[float, float]:
    """Set-point and rate ``into_ns`` after the beginning; before it as at it, after the end at rest."""
    into_ns = max(into_ns, 0)
    for piece in path:
        if into_ns < piece.duration_ns:
            return piece.after(into_ns)
        into_ns -= piece.duration_ns
    return path[-1].after(path[-1].duration_ns)[0], 0.0


def rest_of(path: Sequence[PathPiece], into_ns: int) -> Path:
    """Path from ``into_ns`` after its beginning on."""
    for number, piece in enumerate(path):
        if into_ns < piece.duration_ns:
            r, per_s = piece.after(into_ns)
            per_s2 = piece.per_s2 + piece.per_s3 * into_ns / NS_PER_S
            begun = PathPiece(piece.duration_ns - into_ns, r, per_s, per_s2, piece.per_s3)
            return (begun, *path[number + 1 :])
        into_ns -= piece.duration_ns
    return (PathPiece(0, path[-1].after(path[-1].duration_ns)[0]),)


def to_rest(r: float, rate: float, per_s2: float) -> Path:
    """Path from a set-point that changes at ``rate`` per second to rest, with this deceleration."""
    return joined(r, rate, [(abs(rate) / per_s2, -per_s2 if rate > 0 else per_s2)])


def trapezoid(
    r: float, rate: float, target: float, per_s: float, per_s2: float, down_per_s2: float | None = None
) -> Path:
    """Path from a set-point that changes at ``rate`` to rest at ``target``, as fast as the limits let it:
    ramps of ``per_s2``, at most ``per_s`` in between; ``down_per_s2``: deceleration, if it is another. A
    set-point that is faster at the beginning slows down first; one that cannot stop before the target comes
    back to it."""
    up, down = per_s2, per_s2 if down_per_s2 is None else down_per_s2
    sign = 1.0 if target >= r + rate * abs(rate) / (2 * down) else -1.0
    distance, start = (target - r) * sign, rate * sign
    pieces = []
    if start < 0 and up != down:  # it turns round: two ramps, not one through a stand
        pieces.append((-start / down, down * sign))
        distance += start * start / (2 * down)
        start = 0.0
    # In this order the same ramps both ways give to the bit what a formula of one ramp gives.
    peak = min(per_s, sqrt(max(down / (up + down) * (2 * up * distance + start * start), 0.0)))
    ramp = up if start <= peak else -down
    cruise = distance - (peak * peak - start * start) / (2 * ramp) - peak * peak / (2 * down)
    pieces += [
        (abs(peak - start) / abs(ramp), ramp * sign),
        (max(cruise, 0.0) / peak if peak > 0 else 0.0, 0.0),
        (peak / down, -down * sign),
    ]
    return (*joined(r, rate, pieces)[:-1], PathPiece(0, target))


def joined(r: float, rate: float, pieces: Sequence[tuple[float, float]]) -> Path:
    """Join pieces of (seconds, acceleration), each beginning where the one before ends. Times are rounded to
    whole nanoseconds; set-points and rates are those of the times before rounding, so that no error adds
    up."""
    path = []
    for seconds, per_s2 in pieces:
        if duration_ns := round(seconds * NS_PER_S):
            path.append(PathPiece(duration_ns, r, rate, per_s2))
        r += seconds * (rate + seconds * per_s2 / 2)
        rate += seconds * per_s2
    return (*path, PathPiece(0, r))
