"""Parts of a path: stretches of straight pieces, and what happens between them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from hil.gcode.canonical import Dwell, End, Message, Pause, Place, Switch

Position = tuple[float, ...]
"""Positions of a machine's axes, in the order of ``Machine.axes``: millimetres, degrees."""


class Chord(NamedTuple):
    """Straight piece of a path. Lengths are along the path: millimetres, or degrees if only A B C turn."""

    end: Position
    way: Position
    """From its beginning to its end."""
    length: float
    measure: int
    """Axes that the length is measured over: 0 for X Y Z, 1 for U V W, 2 for A B C."""
    asked_per_s: float
    """Speed that is asked for; infinite: as fast as the axes can."""
    place: Place
    is_arc: bool


@dataclass(frozen=True)
class Stretch:
    """Part of a path between two stops."""

    begin: Position
    chords: Sequence[Chord]
    is_rapid: bool
    tolerance: float
    """Distance from the path that its corners may have; 0: none."""


Item = Stretch | Dwell | Switch | Pause | Message | End
