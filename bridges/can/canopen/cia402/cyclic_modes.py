"""Cyclic synchronous modes: a target with each SYNC, and the set-point on a straight line to it.

Each SYNC gives the set-point one piece of a path, which begins where the one before ends, as the core
computes that end: so a stream of targets is, to the bit, the path of these pieces in one.
"""

from math import copysign

from bridges.can.canopen.cia402.drive_context import DriveContext
from bridges.can.canopen.cia402.movers import PathMover
from bridges.can.canopen.cia402.operating_mode import IDLE_NS, OperatingMode
from bridges.can.canopen.cia402_words import FOLLOWS_TARGET, HALT, INTERPOLATES
from hil.vocab.path import PathPiece
from hil.vocab.time import FOREVER, NS_PER_MS

TIME_OUT_PERIODS, LEAST_TIME_OUT_NS = 3, 50 * NS_PER_MS
"""Time without a SYNC after which the connection counts as lost."""
_S_PER_NS = 1e-9


def end_of(piece: PathPiece) -> float:
    """Set-point at a piece's end, in the core's own arithmetic (``follow_step``)."""
    t = piece.duration_ns * _S_PER_NS
    return piece.r + t * (piece.per_s + t * (piece.per_s2 / 2 + t * piece.per_s3 / 6))


class CyclicMode(OperatingMode):
    """Base of the cyclic modes. ``due_ns``: when a SYNC is missing; FOREVER: none has come yet."""

    def __init__(self, context: DriveContext) -> None:
        super().__init__(context)
        assert isinstance(context.mover, PathMover)
        self._mover = context.mover
        self._is_following = False

    @property
    def watch_ns(self) -> int:
        watch_ns = 2 * self.context.period_ns
        return watch_ns if watch_ns > IDLE_NS else IDLE_NS  # for each SYNC: max() takes twice the time

    def begin(self, word: int, now_ns: int) -> None:
        self._is_following = False
        self.due_ns = FOREVER
        if not self._mover.is_over(now_ns):
            self.stop(1, now_ns)

    def control(self, word: int, before: int, now_ns: int) -> None:
        """Take no bits: these modes have none."""

    def synced(self, now_ns: int) -> None:
        self._is_following = True
        period_ns = self.context.period_ns
        self.due_ns = now_ns + max(TIME_OUT_PERIODS * period_ns, LEAST_TIME_OUT_NS)
        self.follow(period_ns, now_ns)

    def follow(self, period_ns: int, now_ns: int) -> None:
        """Give the set-point its piece for this period."""
        raise NotImplementedError

    def block(self, now_ns: int) -> None:
        if not self._mover.is_over(now_ns):
            super().block(now_ns)

    def stop(self, option: int, now_ns: int) -> None:
        self._is_following = False
        self.due_ns = FOREVER
        super().stop(option, now_ns)

    def status(self, now_ns: int) -> int:
        return FOLLOWS_TARGET if self._is_following else 0


class CyclicPosition(CyclicMode):
    """Mode 8: a target position with each SYNC."""

    target = 0x607A, 0

    def follow(self, period_ns: int, now_ns: int) -> None:
        context = self.context
        target_deg = context.within(context.units.angle_deg(context.value(*self.target)))
        from_deg = self._mover.where_exactly(now_ns)
        t = period_ns * _S_PER_NS
        rate = (target_deg - from_deg) / t
        if abs(rate) > context.max_speed:
            rate = copysign(context.max_speed, rate)
            context.is_limited = True
        if rate and context.is_blocked(rate, now_ns):
            context.is_limited = True
            rate = 0.0
        self._mover.follow(PathPiece(period_ns, from_deg, rate), from_deg + t * rate, now_ns)


class InterpolatedPosition(CyclicPosition):
    """Mode 7, linear: a target position with each SYNC while bit 4 of the controlword is set."""

    target = 0x60C1, 1

    def __init__(self, context: DriveContext) -> None:
        super().__init__(context)
        self._is_asked = False

    def begin(self, word: int, now_ns: int) -> None:
        super().begin(word, now_ns)
        self._is_asked = bool(word & INTERPOLATES)

    def control(self, word: int, before: int, now_ns: int) -> None:
        was_asked, self._is_asked = self._is_asked, bool(word & INTERPOLATES) and not word & HALT
        if was_asked and not self._is_asked:
            self.stop(1, now_ns)

    def synced(self, now_ns: int) -> None:
        if self._is_asked:
            super().synced(now_ns)


class CyclicVelocity(CyclicMode):
    """Mode 9: a target speed with each SYNC, to which the speed changes evenly in one period."""

    def follow(self, period_ns: int, now_ns: int) -> None:
        context = self.context
        asked = context.value(0x60FF) * context.units.deg_per_s
        target = max(-context.max_speed, min(context.max_speed, asked))
        now = self._mover.where(now_ns)
        bound_deg = context.bound_ahead_deg(target)
        is_beyond = bound_deg is not None and (bound_deg - now.deg) * target <= 0
        context.is_limited = target != asked or is_beyond or context.is_blocked(target, now_ns)
        if is_beyond or context.is_blocked(target, now_ns):
            target = 0.0
        t = period_ns * _S_PER_NS
        first = PathPiece(period_ns, now.deg, now.rate, (target - now.rate) / t)
        then_deg = end_of(first)
        then = PathPiece(self.due_ns - now_ns - period_ns, then_deg, target)
        self._mover.go_along((first, then, PathPiece(0, end_of(then), target)), now_ns)
