"""Homing mode: the search for home, leg by leg, and the table of its methods: which switch, which way first,
and which edge is home.

Every method with a switch ends with one slow leg, in the direction ``to_edge``: off the switch, or onto it.
Methods 1 to 14 go on in that direction to the encoder's next index pulse.

Source: IEC 61800-7-201:2015, homing mode, methods 1 to 14, 17 to 30, 33 to 35 and 37.
"""

from collections.abc import Callable, Collection, Generator, Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import NamedTuple

from bridges.can.canopen.cia402.drive_context import DriveContext
from bridges.can.canopen.cia402.motor_axis import HOME, NEGATIVE, POSITIVE, MotorLook
from bridges.can.canopen.cia402.movers import MotionRules
from bridges.can.canopen.cia402.operating_mode import IDLE_NS, OperatingMode
from bridges.can.canopen.cia402_words import HOMING_ATTAINED, HOMING_ERROR, START_HOMING, TARGET_REACHED
from hil.vocab.time import FOREVER


@dataclass(frozen=True)
class HomingMethod:
    """Way to find home. ``first`` and ``to_edge``: directions, 1 or -1."""

    switch: str = ""
    """Name of the switch whose edge is home; empty: none."""
    first: int = 0
    """Direction of the search for the switch."""
    to_edge: int = 0
    """Direction in which the edge is crossed, or the index passed."""
    is_onto: bool = False
    """True if the edge is where the switch becomes active in that direction."""
    turns_back: bool = False
    """True if the limit switch ahead turns the search round; if not, it is an error."""
    by_index: bool = False
    """True if home is the next index pulse."""

    def needs(self) -> Collection[str]:
        """Names of the switches without which it cannot be done."""
        return {self.switch} - {""}


_EDGES: Mapping[int, HomingMethod] = {
    17: HomingMethod(NEGATIVE, -1, 1),
    18: HomingMethod(POSITIVE, 1, -1),
    19: HomingMethod(HOME, 1, -1),
    20: HomingMethod(HOME, 1, 1, is_onto=True),
    21: HomingMethod(HOME, -1, 1),
    22: HomingMethod(HOME, -1, -1, is_onto=True),
    23: HomingMethod(HOME, 1, -1, turns_back=True),
    24: HomingMethod(HOME, 1, 1, is_onto=True, turns_back=True),
    25: HomingMethod(HOME, 1, -1, is_onto=True, turns_back=True),
    26: HomingMethod(HOME, 1, 1, turns_back=True),
    27: HomingMethod(HOME, -1, 1, turns_back=True),
    28: HomingMethod(HOME, -1, -1, is_onto=True, turns_back=True),
    29: HomingMethod(HOME, -1, 1, is_onto=True, turns_back=True),
    30: HomingMethod(HOME, -1, -1, turns_back=True),
}
_BEFORE_INDEX = 16
METHODS: Mapping[int, HomingMethod] = {
    **{
        number - _BEFORE_INDEX: HomingMethod(
            each.switch, each.first, each.to_edge, each.is_onto, each.turns_back, by_index=True
        )
        for number, each in _EDGES.items()
    },
    **_EDGES,
    33: HomingMethod(to_edge=-1, by_index=True),
    34: HomingMethod(to_edge=1, by_index=True),
    35: HomingMethod(),
    37: HomingMethod(),
}
"""All methods by their numbers; 35 and 37 take the present position."""


def methods_of(switches: Collection[str], *, has_index: bool) -> tuple[int, ...]:
    """Numbers of the methods that can be done with these switches, and an index pulse or none."""
    return tuple(
        number
        for number, method in sorted(METHODS.items())
        if set(method.needs()) <= set(switches) and (has_index or not method.by_index)
    )


WATCH_NS = 250_000
"""Time from one look at the switches to the next."""


class HomingLeg(NamedTuple):
    """Part of the search: a direction, a speed, and what ends it."""

    direction: int
    is_fast: bool
    is_over: Callable[[MotorLook], bool]


class HomingEnd(NamedTuple):
    """Position of the shaft when a leg was over; ``by_limit``: a limit switch ended it."""

    at_deg: float
    by_limit: bool


Search = Generator[HomingLeg, HomingEnd, float | None]
"""Procedure: legs, and home in the end; None: it was not found."""


def search(method: HomingMethod, look: MotorLook, index_deg: float | None) -> Search:
    """Search home: first the switch, then its edge, then the index."""
    here_deg = look.position_deg
    if method.switch:
        found_deg = yield from _edge(method, is_active=bool(look.inputs[method.switch]))
        if found_deg is None:
            return None
        here_deg = found_deg
    if method.by_index:
        assert index_deg is not None  # the method was refused without one
        target_deg = _next_index(here_deg, index_deg, method.to_edge)
        sign = method.to_edge
        end = yield HomingLeg(sign, False, lambda look: (look.position_deg - target_deg) * sign >= 0)
        return None if end.by_limit else target_deg
    return here_deg


def _edge(method: HomingMethod, *, is_active: bool) -> Generator[HomingLeg, HomingEnd, float | None]:
    switch = method.switch

    def active(look: MotorLook) -> bool:
        return bool(look.inputs[switch])

    def inactive(look: MotorLook) -> bool:
        return not look.inputs[switch]

    if not is_active:
        approach = method.first
        end = yield HomingLeg(approach, True, active)
        if end.by_limit and method.turns_back:
            approach = -approach
            end = yield HomingLeg(approach, True, active)
        if not end.by_limit:  # it may have run over a narrow cam while it came to rest
            end = yield HomingLeg(-approach, False, active)
        if end.by_limit:
            return None
    if method.is_onto:
        end = yield HomingLeg(-method.to_edge, False, inactive)
        if end.by_limit:
            return None
    end = yield HomingLeg(method.to_edge, False, active if method.is_onto else inactive)
    return None if end.by_limit else end.at_deg


def _next_index(here_deg: float, index_deg: float, direction: int) -> float:
    """Angle of the next index pulse in a direction."""
    turns = (here_deg - index_deg) / 360
    return index_deg + 360 * (floor(turns) + 1 if direction > 0 else ceil(turns) - 1)


class Homing(OperatingMode):
    """Mode 6. ``is_home``: home was found since power-up, and no other search has begun."""

    obeys_limits = False

    def __init__(self, context: DriveContext) -> None:
        super().__init__(context)
        self._search: Search | None = None
        self._leg: HomingLeg | None = None
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
        method = METHODS[number]
        self._ended = None
        self._search = search(method, context.look(now_ns), context.axis.index_deg)
        self._next(None, now_ns)

    def _next(self, end: HomingEnd | None, now_ns: int) -> None:
        """Begin the search's next leg, or end it. A leg that is over before it begins is left out."""
        assert self._search
        look = self.context.look(now_ns)
        try:
            self._leg = next(self._search) if end is None else self._search.send(end)
            while self._leg.is_over(look):
                self._leg = self._search.send(HomingEnd(look.position_deg, by_limit=False))
        except StopIteration as done:
            self._search = self._leg = None
            home_deg: float | None = done.value
            self._has_failed = home_deg is None
            if home_deg is not None:
                self.context.take_home(home_deg)
                self._is_home = True
            return
        self._run(now_ns)

    def _run(self, now_ns: int) -> None:
        if self._leg is None or self.is_halted:
            return
        context = self.context
        self._is_at_rest = False
        unit = abs(context.units.deg_per_s)
        speed = min(context.steps(0x6099, 1 if self._leg.is_fast else 2) * unit, context.max_speed)
        ramp = self.ramp(is_quick=False)
        context.mover.turn(speed * self._leg.direction, MotionRules(speed, ramp, ramp), now_ns)
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
        look = context.look(now_ns)
        stops = self._leg is None or self._ended is not None or self.is_halted or self._search is None
        if stops:
            if not context.mover.is_over(now_ns):
                self.due_ns = context.mover.due_ns
                return
            self.due_ns = FOREVER
            self._is_at_rest = True
            if self._search and self._ended and not self.is_halted:
                ended, self._ended = self._ended, None
                self._next(ended, now_ns)
            return
        assert self._leg
        if self._leg.is_over(look):
            self._end_leg(HomingEnd(look.position_deg, by_limit=False), now_ns)
        elif look.inputs.get(POSITIVE if self._leg.direction > 0 else NEGATIVE):
            self._end_leg(HomingEnd(look.position_deg, by_limit=True), now_ns)

    def _end_leg(self, end: HomingEnd, now_ns: int) -> None:
        self._ended = end
        self.stop(1, now_ns)

    def status(self, now_ns: int) -> int:
        bits = HOMING_ATTAINED if self._is_home else 0
        if self._has_failed:
            bits |= HOMING_ERROR
        is_busy = self._search is not None and not self.is_halted
        return bits | (TARGET_REACHED if self._is_at_rest and not is_busy else 0)
