"""Search for home by the methods of CiA 402: which switch, which way first, and which edge is home; leg by
leg, for drives on any bus.

Every method with a switch ends with one slow leg, in the direction ``to_edge``: off the switch, or onto it.
Methods 1 to 14 go on in that direction to the encoder's next index pulse.

Source: IEC 61800-7-201:2015, homing mode, methods 1 to 14, 17 to 30, 33 to 35 and 37.
"""

from collections.abc import Callable, Collection, Generator, Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import NamedTuple, Protocol

HOME, NEGATIVE, POSITIVE = "home", "negative", "positive"
"""Names of the switches: homing, and the limit switches at both ends."""


class HomingLook(Protocol):
    """Axis at one time, as the search looks at it."""

    @property
    def position_deg(self) -> float:
        """Angle of the shaft with turns."""

    @property
    def inputs(self) -> Mapping[str, int]:
        """Levels of switches by name, 1 active: those of ``HOME``, ``NEGATIVE`` and ``POSITIVE`` that are."""


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


class HomingLeg(NamedTuple):
    """Part of the search: a direction, a speed, and what ends it."""

    direction: int
    is_fast: bool
    is_over: Callable[[HomingLook], bool]


class HomingEnd(NamedTuple):
    """Position of the shaft when a leg was over; ``by_limit``: a limit switch ended it."""

    at_deg: float
    by_limit: bool


_Legs = Generator[HomingLeg, HomingEnd, float | None]
"""Procedure: legs, and home in the end; None: it was not found."""


class HomingSearch:
    """Search that has begun. The caller turns the axis as ``leg`` says, looks, and lets it come to rest
    where ``end_of_leg`` says that the leg is over; then ``go_on`` has the next one. ``index_deg``: angle
    within a turn of the index pulse; None: there is none, and no method with it."""

    def __init__(self, method: HomingMethod, look: HomingLook, index_deg: float | None) -> None:
        self._legs = _search(method, look, index_deg)
        self.leg: HomingLeg | None = None
        """Leg that is to be made; None: the search is over."""
        self.home_deg: float | None = None
        """Angle of home once it is found."""
        self.go_on(None, look)

    def end_of_leg(self, look: HomingLook) -> HomingEnd | None:
        """End of the leg, if it is over: by what it searches, or by the limit switch ahead."""
        if self.leg is None:
            return None
        if self.leg.is_over(look):
            return HomingEnd(look.position_deg, by_limit=False)
        if look.inputs.get(POSITIVE if self.leg.direction > 0 else NEGATIVE):
            return HomingEnd(look.position_deg, by_limit=True)
        return None

    def go_on(self, end: HomingEnd | None, look: HomingLook) -> None:
        """Begin the leg behind one that has ended so, or the first. One that is over before it begins is left
        out."""
        try:
            self.leg = next(self._legs) if end is None else self._legs.send(end)
            while self.leg.is_over(look):
                self.leg = self._legs.send(HomingEnd(look.position_deg, by_limit=False))
        except StopIteration as done:
            self.leg = None
            self.home_deg = done.value


def _search(method: HomingMethod, look: HomingLook, index_deg: float | None) -> _Legs:
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


def _edge(method: HomingMethod, *, is_active: bool) -> _Legs:
    switch = method.switch

    def active(look: HomingLook) -> bool:
        return bool(look.inputs[switch])

    def inactive(look: HomingLook) -> bool:
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
