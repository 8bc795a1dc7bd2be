"""Profile position mode: set-points by handshake, one of them waiting."""

from typing import NamedTuple

from bridges.can.canopen.cia402.drive_context import DriveContext
from bridges.can.canopen.cia402.movers import MotionRules
from bridges.can.canopen.cia402.operating_mode import IDLE_NS, WATCH_NS, OperatingMode, TimeWindow
from bridges.can.canopen.cia402_words import (
    CHANGE_AT_ONCE,
    CHANGE_ON_SET_POINT,
    NEW_SET_POINT,
    RELATIVE,
    SET_POINT_TAKEN,
    TARGET_REACHED,
)
from hil.vocab.time import FOREVER


class TargetEntry(NamedTuple):
    """Set-point of the handshake, with its rules."""

    angle_deg: float
    rules: MotionRules
    is_passed: bool
    """True if it begins while the one before is passed, and not when that one is reached."""


class ProfilePosition(OperatingMode):
    """Mode 1. A set-point's values are those at the rising edge of bit 4."""

    def __init__(self, context: DriveContext) -> None:
        super().__init__(context)
        self._active: TargetEntry | None = None
        self._waiting: TargetEntry | None = None
        self._last_deg = 0.0
        self._is_new = False
        self._is_acknowledged = False
        self._is_blocked = False
        self._is_reached = True
        self._window = TimeWindow()

    @property
    def watch_ns(self) -> int:
        return IDLE_NS if self._is_reached or self._is_blocked else WATCH_NS

    def begin(self, word: int, now_ns: int) -> None:
        context = self.context
        now = context.mover.where(now_ns)
        self._active = self._waiting = None
        self._last_deg = now.deg
        self._is_new, self._is_acknowledged = bool(word & NEW_SET_POINT), False
        self._is_blocked, self._is_reached = False, True
        self._window.assume()
        self.is_halted = False
        if not context.mover.is_over(now_ns):  # another mode was under way
            self.stop(1, now_ns)
            self._last_deg = context.mover.where(context.mover.due_ns).deg
        super().control(word, 0, now_ns)
        self.due_ns = context.mover.due_ns

    def control(self, word: int, before: int, now_ns: int) -> None:
        is_new = bool(word & NEW_SET_POINT)
        if is_new and not self._is_new:
            self._take(word, now_ns)
        self._is_new = is_new
        if not is_new and self._waiting is None:
            self._is_acknowledged = False
        super().control(word, before, now_ns)

    def _take(self, word: int, now_ns: int) -> None:
        if self._waiting and not word & CHANGE_AT_ONCE:
            return  # there is no place for it: bit 12 says so
        entry = self._entry(word)
        self._is_acknowledged = True
        self._last_deg = entry.angle_deg
        if word & CHANGE_AT_ONCE or self._active is None:
            self._waiting = None
            self._start(entry, now_ns)
            return
        self._waiting = entry
        if entry.is_passed and not self.is_halted:
            self.context.mover.pass_through(self._active.angle_deg, self._active.rules, now_ns)
            self._moved()

    def _entry(self, word: int) -> TargetEntry:
        context = self.context
        target = context.value(0x607A)
        if word & RELATIVE:
            angle_deg = self._last_deg + context.units.distance_deg(target)
        else:
            angle_deg = context.units.angle_deg(target)
        return TargetEntry(context.within(angle_deg), context.rules(), bool(word & CHANGE_ON_SET_POINT))

    def _start(self, entry: TargetEntry, now_ns: int) -> None:
        context = self.context
        self._active, self._is_reached = entry, False
        self._window.clear()
        way_deg = entry.angle_deg - context.mover.where(now_ns).deg
        self._is_blocked = context.is_blocked(way_deg, now_ns)
        if self._is_blocked:
            self._active = None
            context.is_limited = True
        elif not self.is_halted:
            context.mover.go(entry.angle_deg, entry.rules, now_ns)
        self._moved()

    def _moved(self) -> None:
        self.context.forget()
        self.due_ns = self.context.mover.due_ns

    def halt(self, now_ns: int) -> None:
        super().halt(now_ns)
        self._is_reached = False
        self._moved()

    def go_on(self, now_ns: int) -> None:
        if self._active:
            self._start(self._active, now_ns)

    def block(self, now_ns: int) -> None:
        self._active = self._waiting = None
        self._is_blocked = True
        self._is_acknowledged &= self._is_new
        super().block(now_ns)
        self._last_deg = self.context.mover.where(self.context.mover.due_ns).deg
        self._moved()

    def step(self, now_ns: int) -> None:
        context = self.context
        is_over = context.mover.is_over(now_ns)
        self.due_ns = context.mover.due_ns
        if not is_over:
            return
        self.due_ns = FOREVER
        if self.is_halted:
            self._is_reached = True
            return
        if self._waiting:
            entry, self._waiting = self._waiting, None
            self._is_acknowledged &= self._is_new
            self._start(entry, now_ns)
            return
        off_deg = abs(context.following_error_deg(now_ns))
        is_there = off_deg <= context.window_deg(0x6067)
        self._is_reached = self._window.holds(is_there, context.ms(0x6068), now_ns) and not self._is_blocked
        if self._is_reached:
            self._active = None

    def status(self, now_ns: int) -> int:
        return (TARGET_REACHED if self._is_reached else 0) | (SET_POINT_TAKEN if self._is_acknowledged else 0)
