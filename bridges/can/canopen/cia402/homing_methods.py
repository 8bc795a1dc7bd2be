"""Table of homing methods: which switch, which way first, and which edge is home.

Every method with a switch ends with one slow leg, in the direction ``to_edge``: off the switch, or onto it.
Methods 1 to 14 go on in that direction to the encoder's next index pulse.

Source: IEC 61800-7-201:2015, homing mode, methods 1 to 14, 17 to 30, 33 to 35 and 37.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from bridges.can.canopen.cia402.motor_axis import HOME, NEGATIVE, POSITIVE


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
