"""Ramps of a drive's set-point, from any motion: to an angle, through one, to a speed, to rest.

Trapezoids have a deceleration of their own; with a jerk the lesser of both accelerations counts for both.
"""

from dataclasses import dataclass, replace
from math import copysign, sqrt

from hil.core.trajectory import AxisLimits, PlanError, PointState, plan_joint, plan_velocity
from hil.firmware.set_point_paths import joined, to_rest, trapezoid
from hil.vocab.path import Path, PathPiece
from hil.vocab.time import NS_PER_S

ENDLESS_NS = 10**18
"""Duration of a motion without an end: 31 years."""


@dataclass(frozen=True)
class MotionRules:
    """Speed of a motion in deg/s, accelerations in deg/s2, jerk in deg/s3; None: accelerations begin at
    once."""

    speed: float
    acceleration: float
    deceleration: float
    jerk: float | None = None


@dataclass(frozen=True)
class SetPointNow:
    """Set-point in degrees, and its first two derivatives by the second."""

    deg: float
    rate: float = 0.0
    acceleration: float = 0.0


def to_target(now: SetPointNow, target_deg: float, rules: MotionRules) -> Path:
    """Plan to rest at an angle, as soon as the rules let it. What is too fast slows down first; what cannot
    stop in time comes back."""
    if rules.jerk is not None and (path := _s_curve(now, target_deg, rules)):
        return (*path, PathPiece(0, target_deg))
    return trapezoid(now.deg, now.rate, target_deg, rules.speed, rules.acceleration, rules.deceleration)


def through(now: SetPointNow, target_deg: float, rules: MotionRules) -> tuple[Path, float] | None:
    """Plan to an angle without stopping there; answers the rate with which the set-point passes it. None: it
    would have to turn back."""
    sign = copysign(1.0, target_deg - now.deg)
    start, distance = now.rate * sign, abs(target_deg - now.deg)
    if start < 0 or distance == 0.0:
        return None
    ramp = rules.acceleration if start <= rules.speed else -rules.deceleration
    end_squared = max(start * start + 2 * ramp * distance, 0.0)
    fits = min if ramp > 0 else max
    peak = fits(rules.speed, sqrt(end_squared))
    cruise = distance - (peak * peak - start * start) / (2 * ramp)
    pieces = [(abs(peak - start) / abs(ramp), ramp * sign), (max(cruise, 0.0) / peak, 0.0)]
    return (*joined(now.deg, now.rate, pieces)[:-1], PathPiece(0, target_deg)), peak * sign


def to_speed(now: SetPointNow, rate: float, rules: MotionRules) -> Path:
    """Plan to a speed in deg/s, with its sign, with which it then goes on."""
    pieces: list[PathPiece] = []
    if rules.jerk is not None:
        pieces = _s_curve_to_speed(now, rate, rules)
    if not pieces:
        pieces = list(_ramps_to_speed(now, rate, rules))
        return (*pieces[:-1], replace(pieces[-1], duration_ns=ENDLESS_NS if rate else 0, per_s=rate))
    last = pieces[-1]
    seconds = last.duration_ns / NS_PER_S
    end_deg = last.r + seconds * (last.per_s + seconds * (last.per_s2 / 2 + seconds * last.per_s3 / 6))
    return (*pieces, PathPiece(ENDLESS_NS if rate else 0, end_deg, rate))


def to_a_stop(now: SetPointNow, deceleration: float) -> Path:
    """Plan to rest with a deceleration in deg/s2."""
    return to_rest(now.deg, now.rate, deceleration)


def _ramps_to_speed(now: SetPointNow, rate: float, rules: MotionRules) -> Path:
    pieces = []
    start = now.rate
    if start * rate < 0 or abs(rate) < abs(start):
        low = 0.0 if start * rate < 0 else rate
        pieces.append((abs(start - low) / rules.deceleration, copysign(rules.deceleration, -start)))
        start = low
    if start != rate:
        pieces.append((abs(rate - start) / rules.acceleration, copysign(rules.acceleration, rate - start)))
    return joined(now.deg, now.rate, pieces)


def _limits(now: SetPointNow, rules: MotionRules) -> list[AxisLimits]:
    assert rules.jerk is not None
    least = min(rules.acceleration, rules.deceleration)
    return [AxisLimits(max(rules.speed, abs(now.rate)), max(least, abs(now.acceleration)), rules.jerk)]


def _s_curve(now: SetPointNow, target_deg: float, rules: MotionRules) -> list[PathPiece]:
    try:
        start = PointState(now.deg, now.rate, now.acceleration)
        return plan_joint([start], [target_deg], _limits(now, rules)).pieces(0)
    except PlanError:  # the start itself leads beyond the limits: without a jerk it always goes
        return []


def _s_curve_to_speed(now: SetPointNow, rate: float, rules: MotionRules) -> list[PathPiece]:
    try:
        start = PointState(now.deg, now.rate, now.acceleration)
        return plan_velocity([start], [rate], _limits(now, rules)).pieces(0)
    except PlanError:
        return []
