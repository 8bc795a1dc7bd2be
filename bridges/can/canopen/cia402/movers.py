"""Movers: what modes let an axis do, by paths of its set-point or by ramps of its own; and these paths, from
any motion: to an angle, through one, to a speed, to rest.

Trapezoids have a deceleration of their own; with a jerk the lesser of both accelerations counts for both.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import copysign, sqrt
from typing import Protocol, TypeVar

from bridges.can.canopen.cia402.motor_axis import MotorAxis, MotorLook
from hil.core.trajectory import AxisLimits, PlanError, PointState, plan_joint, plan_velocity
from hil.firmware.set_point_paths import joined, length_ns, to_rest, trapezoid
from hil.vocab.path import DEG_PER_S, Path, PathPiece
from hil.vocab.time import FOREVER, NS_PER_MS, NS_PER_S
from hil.vocab.verbs import VerbRefused

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
        return (*pieces[:-1], pieces[-1]._replace(duration_ns=ENDLESS_NS if rate else 0, per_s=rate))
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


LOOK_NS = NS_PER_MS
"""Time from one look to the next at a motion whose end is not known."""


_LONGEST_NS = 2**61
_SHOWS_NS, _OTHER_DEG = NS_PER_MS, 0.01
"""Time after a path's end by which a control step has taken it, and a distance beyond rounding."""
Planned = TypeVar("Planned")


class Mover(Protocol):
    """Mover of an axis. What moves it raises ``VerbRefused``."""

    due_ns: int
    """Time at which ``is_over`` may have changed; FOREVER: nothing is under way, or it has no end."""

    def begin(self, look: MotorLook, rate: float = 0.0) -> None:
        """Begin at what the axis does now; ``rate``: its speed in deg/s, if it has one that is to count."""

    def check(self, look: MotorLook) -> None:
        """Begin again if somebody else has moved or stopped the axis meanwhile, such as a run."""

    def where(self, now_ns: int) -> SetPointNow:
        """Set-point now."""

    def is_over(self, now_ns: int) -> bool:
        """True if the set-point stands, or is where it was sent."""

    def go(self, target_deg: float, rules: MotionRules, now_ns: int) -> None:
        """Go to an angle."""

    def pass_through(self, target_deg: float, rules: MotionRules, now_ns: int) -> bool:
        """Go to an angle and be there in motion, for what comes next; False: it cannot."""

    def turn(self, rate: float, rules: MotionRules, now_ns: int, bound_deg: float | None = None) -> None:
        """Turn at a speed in deg/s, with its sign. ``bound_deg``: angle ahead at which it ends."""

    def stop(self, deceleration: float, now_ns: int, *, at_once: bool = False) -> None:
        """Come to rest with a deceleration in deg/s2, or at once."""


class PathMover:
    """Mover of an axis that follows paths."""

    def __init__(self, axis: MotorAxis) -> None:
        self._axis = axis
        self.due_ns: int = FOREVER
        self._path: Path = (PathPiece(0, 0.0),)
        self._from_ns = self._end_ns = 0
        self._end_deg = self._end_rate = 0.0

    def begin(self, look: MotorLook, rate: float = 0.0) -> None:
        has_angle = look.commanded_deg is not None and not rate
        here_deg = look.commanded_deg if has_angle else look.position_deg
        assert here_deg is not None
        self._path, self._from_ns, self._end_ns = (PathPiece(0, here_deg),), 0, look.at_ns
        self._end_deg, self._end_rate, self.due_ns = here_deg, rate, FOREVER

    def check(self, look: MotorLook) -> None:
        is_deg, now_ns = look.commanded_deg, look.at_ns
        if is_deg is None:
            return
        if now_ns < self._end_ns:  # the path may be broken off
            is_other = not look.is_moving and now_ns >= self._from_ns + _SHOWS_NS
        else:
            off_deg = abs(is_deg - self._end_deg)
            is_other = now_ns >= self._end_ns + _SHOWS_NS and off_deg > max(_OTHER_DEG, abs(is_deg) * 1e-6)
        if is_other:
            self.begin(look)

    def where(self, now_ns: int) -> SetPointNow:
        if now_ns >= self._end_ns:
            return SetPointNow(self._end_deg, self._end_rate if now_ns == self._end_ns else 0.0)
        into_ns = now_ns - self._from_ns
        for piece in self._path:
            if into_ns < piece.duration_ns:
                break
            into_ns -= piece.duration_ns
        seconds = into_ns / NS_PER_S
        return SetPointNow(*piece.after(into_ns), piece.per_s2 + seconds * piece.per_s3)

    def is_over(self, now_ns: int) -> bool:
        return now_ns >= self._end_ns

    def go(self, target_deg: float, rules: MotionRules, now_ns: int) -> None:
        self._send(_planned(lambda: to_target(self.where(now_ns), target_deg, rules)), now_ns)

    def pass_through(self, target_deg: float, rules: MotionRules, now_ns: int) -> bool:
        found = _planned(lambda: through(self.where(now_ns), target_deg, rules))
        if found is None:
            return False
        self._send(found[0], now_ns)
        self._end_rate = found[1]
        return True

    def turn(self, rate: float, rules: MotionRules, now_ns: int, bound_deg: float | None = None) -> None:
        if rate and bound_deg is not None:
            self.go(bound_deg, rules, now_ns)
        else:
            self._send(_planned(lambda: to_speed(self.where(now_ns), rate, rules)), now_ns)

    def stop(self, deceleration: float, now_ns: int, *, at_once: bool = False) -> None:
        if not at_once:
            self._send(_planned(lambda: to_a_stop(self.where(now_ns), deceleration)), now_ns)
            return
        self._axis.stop("prejudice", deceleration / DEG_PER_S)
        self.begin(self._axis.look())

    def where_exactly(self, now_ns: int) -> float:
        """Set-point now, in the core's own arithmetic: of a path that has ended its end."""
        if now_ns >= self._end_ns:
            return self._end_deg
        piece = self._path[0]
        if now_ns - self._from_ns > piece.duration_ns:
            return self.where(now_ns).deg
        t = (now_ns - self._from_ns) * 1e-9
        return piece.r + t * (piece.per_s + t * (piece.per_s2 / 2 + t * piece.per_s3 / 6))

    def follow(self, piece: PathPiece, end_deg: float, now_ns: int) -> None:
        """Follow one piece, which ends at an angle."""
        path = (piece,)
        self._axis.follow(path, now_ns)
        self._path, self._from_ns, self._end_ns = path, now_ns, now_ns + piece.duration_ns
        self._end_deg, self._end_rate = end_deg, 0.0
        self.due_ns = FOREVER

    def go_along(self, path: Path, now_ns: int) -> None:
        """Go along a path, for now."""
        self._send(path, now_ns)
        self.due_ns = FOREVER

    def _send(self, path: Path, now_ns: int) -> None:
        duration_ns = length_ns(path)
        if duration_ns > _LONGEST_NS:
            raise VerbRefused("bad_parameter", f"it would take {duration_ns / NS_PER_S:.3g} s")
        self._axis.follow(path, now_ns)
        self._path, self._from_ns, self._end_ns = path, now_ns, now_ns + duration_ns
        self._end_deg, self._end_rate = path[-1].r, 0.0
        self.due_ns = self._end_ns


def _planned(plan: Callable[[], Planned]) -> Planned:
    """Plan. Raises VerbRefused: the numbers are too far apart."""
    try:
        return plan()
    except (OverflowError, ValueError, ZeroDivisionError) as error:
        raise VerbRefused("bad_parameter", f"no path leads there: {error}") from None


class RampMover:
    """Mover of an axis that makes ramps of its own, and takes a new angle only when it stands."""

    def __init__(self, axis: MotorAxis) -> None:
        self._axis = axis
        self.due_ns: int = FOREVER
        self._next: tuple[float, MotionRules] | None = None
        self._is_endless = False

    def begin(self, look: MotorLook, rate: float = 0.0) -> None:
        self._next, self._is_endless = None, False
        self.due_ns = look.at_ns if look.is_moving else FOREVER

    def check(self, look: MotorLook) -> None:
        """Do nothing: the position is read each time."""

    def where(self, now_ns: int) -> SetPointNow:
        look = self._axis.look()
        here_deg = look.position_deg if look.commanded_deg is None else look.commanded_deg
        return SetPointNow(here_deg, look.velocity_rpm * DEG_PER_S)

    def is_over(self, now_ns: int) -> bool:
        if self._axis.look().is_moving:
            self.due_ns = FOREVER if self._is_endless else now_ns + LOOK_NS
            return False
        if self._next:
            self.go(*self._next, now_ns)
            return False
        self.due_ns = FOREVER
        return True

    def go(self, target_deg: float, rules: MotionRules, now_ns: int) -> None:
        self._is_endless, self.due_ns = False, now_ns + LOOK_NS
        if self._axis.look().is_moving:
            self._next = target_deg, rules
            self._axis.stop("grace", rules.deceleration / DEG_PER_S)
            return
        self._next = None
        self._axis.move_abs(target_deg, rules.speed / DEG_PER_S, rules.acceleration / DEG_PER_S)

    def pass_through(self, target_deg: float, rules: MotionRules, now_ns: int) -> bool:
        return False

    def turn(self, rate: float, rules: MotionRules, now_ns: int, bound_deg: float | None = None) -> None:
        if rate and bound_deg is not None:
            self.go(bound_deg, rules, now_ns)
            return
        self._next, self._is_endless = None, bool(rate)
        self.due_ns = FOREVER if rate else now_ns + LOOK_NS
        self._axis.velocity(rate / DEG_PER_S)

    def stop(self, deceleration: float, now_ns: int, *, at_once: bool = False) -> None:
        self._next, self._is_endless, self.due_ns = None, False, now_ns + LOOK_NS
        self._axis.stop("prejudice" if at_once else "grace", deceleration / DEG_PER_S)
