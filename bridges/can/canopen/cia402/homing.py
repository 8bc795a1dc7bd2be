"""Homing mode: the search for home, leg by leg, by the methods of ``hil.firmware.homing_methods``."""

from bridges.can.canopen.cia402.drive_context import DriveContext
from bridges.can.canopen.cia402.movers import MotionRules
from bridges.can.canopen.cia402.operating_mode import IDLE_NS, OperatingMode
from bridges.can.canopen.cia402_words import HOMING_ATTAINED, HOMING_ERROR, START_HOMING, TARGET_REACHED
from hil.firmware.homing_methods import METHODS, HomingEnd, HomingSearch, methods_of
from hil.vocab.time import FOREVER

WATCH_NS = 250_000
"""Time from one look at the switches to the next."""


class Homing(OperatingMode):
    """Mode 6. ``is_home``: home was found since power-up, and no other search has begun."""

    obeys_limits = False

    def __init__(self, context: DriveContext) -> None:
        super().__init__(context)
        self._search: HomingSearch | None = None
        self._ended: HomingEnd | None = None
        """End of the leg from which the axis comes to rest now."""
        self._is_started = self._is_home = self._has_failed = False
        self._is_at_rest = True

    @property
    def watch_ns(self) -> int:
        return IDLE_NS if self._is_at_rest else WATCH_NS

    def begin(self, word: int, now_ns: int) -> None:
        self._search = None
        self._is_started = self._has_failed = self.is_halted = False
        if not self.context.mover.is_over(now_ns):
            self.stop(1, now_ns)
        self.control(word, 0, now_ns)

    def ramp(self, *, is_quick: bool) -> float:
        if is_quick:
            return super().ramp(is_quick=True)
        return self.context.steps(0x609A) * self.context.units.deg_per_s2

    def control(self, word: int, before: int, now_ns: int) -> None:
        is_started = bool(word & START_HOMING)
        if is_started and not self._is_started:
            self._is_started = True
            self._start(now_ns)
        elif not is_started and self._is_started:
            self._is_started = False
            if self._search:
                self._search = None
                self.stop(1, now_ns)
        super().control(word, before, now_ns)

    def _start(self, now_ns: int) -> None:
        context = self.context
        number = context.value(0x6098)
        self._is_home = self._has_failed = False
        if number not in methods_of(
            context.look(now_ns).inputs, has_index=context.axis.index_deg is not None
        ):
            self._has_failed = True
            return
        self._ended = None
        self._search = HomingSearch(METHODS[number], context.look(now_ns), context.axis.index_deg)
        self._begin_leg(self._search, now_ns)

    def _begin_leg(self, search: HomingSearch, now_ns: int) -> None:
        if search.leg is None:
            self._search = None
            self._has_failed = search.home_deg is None
            if search.home_deg is not None:
                self.context.take_home(search.home_deg)
                self._is_home = True
            return
        self._run(now_ns)

    def _run(self, now_ns: int) -> None:
        leg = self._search.leg if self._search else None
        if leg is None or self.is_halted:
            return
        context = self.context
        self._is_at_rest = False
        unit = abs(context.units.deg_per_s)
        speed = min(context.steps(0x6099, 1 if leg.is_fast else 2) * unit, context.max_speed)
        ramp = self.ramp(is_quick=False)
        context.mover.turn(speed * leg.direction, MotionRules(speed, ramp, ramp), now_ns)
        context.forget()

    def stop(self, option: int, now_ns: int) -> None:
        super().stop(option, now_ns)
        self._is_at_rest = False
        self.due_ns = self.context.mover.due_ns

    def go_on(self, now_ns: int) -> None:
        if self._ended is None:
            self._run(now_ns)

    def step(self, now_ns: int) -> None:
        context = self.context
        if self._search is None or self._ended is not None or self.is_halted:
            if not context.mover.is_over(now_ns):
                self.due_ns = context.mover.due_ns
                return
            self.due_ns = FOREVER
            self._is_at_rest = True
            if self._search and self._ended and not self.is_halted:
                ended, self._ended = self._ended, None
                self._search.go_on(ended, context.look(now_ns))
                self._begin_leg(self._search, now_ns)
        elif end := self._search.end_of_leg(context.look(now_ns)):
            self._ended = end
            self.stop(1, now_ns)

    def status(self, now_ns: int) -> int:
        bits = HOMING_ATTAINED if self._is_home else 0
        if self._has_failed:
            bits |= HOMING_ERROR
        is_busy = self._search is not None and not self.is_halted
        return bits | (TARGET_REACHED if self._is_at_rest and not is_busy else 0)
