"""Canonical motions: what a program asks of a machine, after units, offsets and modes are applied.

Lengths are in millimetres, angles in degrees, positions in machine coordinates.
"""

from collections.abc import Mapping
from typing import Literal, NamedTuple

from hil.vocab.problem import Problem

Plane = Literal["xy", "xz", "yz"]
FeedKind = Literal["per_minute", "inverse_time", "per_revolution"]
SwitchName = Literal["spindle", "mist", "flood"]
SwitchState = Literal["off", "on", "cw", "ccw"]
PathModeKind = Literal["exact_path", "exact_stop", "blend"]

PLANE_AXES: Mapping[Plane, tuple[int, int, int]] = {"xy": (0, 1, 2), "xz": (2, 0, 1), "yz": (1, 2, 0)}
"""Indices in a ``Point`` of a plane's first and second axis and of the axis across it, which makes a
right-handed set: x y z, z x y, y z x."""


class TextPlace(NamedTuple):
    """Place in a program's text. Both count from 1; a column counts characters."""

    line: int
    column: int


class Point(NamedTuple):
    """Position of all axes: X Y Z U V W in millimetres, A B C in degrees."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    a: float = 0.0
    b: float = 0.0
    c: float = 0.0
    u: float = 0.0
    v: float = 0.0
    w: float = 0.0


class Feed(NamedTuple):
    """Speed of a motion, above 0.

    ``per_minute``: millimetres in a minute along the path of X Y Z, or along that of U V W if X Y Z stay, or
    degrees in a minute if only A B C turn. ``inverse_time``: how often in a minute this motion could be done.
    ``per_revolution``: as ``per_minute``, for each turn of the spindle.
    """

    kind: FeedKind
    value: float


class Straight(NamedTuple):
    """Straight line from where the motion before ended. ``feed`` is None for a rapid."""

    place: TextPlace
    is_rapid: bool
    end: Point
    feed: Feed | None


class Arc(NamedTuple):
    """Circle or helix from where the motion before ended; axes outside the plane go along in proportion.

    ``centre`` is that of the plane's first and second axis, in the order of ``PLANE_AXES``. ``turns`` is
    above 0 for counterclockwise, below for clockwise, seen from the positive end of the axis across the
    plane. 1 and -1 are arcs of at most one turn: a whole circle if the motion begins where it ends in the
    plane. Each further number is one turn more. The radii at the beginning and at the end may differ by the
    tolerance of the language.
    """

    place: TextPlace
    plane: Plane
    end: Point
    centre: tuple[float, float]
    turns: int
    feed: Feed


class Dwell(NamedTuple):
    """Wait of ``seconds``, 0 or more."""

    place: TextPlace
    seconds: float


class Switch(NamedTuple):
    """Spindle or coolant on or off. The spindle's states are ``off``, ``cw`` and ``ccw``, with ``speed_rpm``
    (0 or more), which is None for all others."""

    place: TextPlace
    name: SwitchName
    state: SwitchState
    speed_rpm: float | None


class Pause(NamedTuple):
    """Wait until somebody resumes: M0, M6; M1 is optional."""

    place: TextPlace
    is_optional: bool


class PathMode(NamedTuple):
    """Mode of passing corners from here on. ``tolerance_mm`` belongs to ``blend``: None leaves it open."""

    place: TextPlace
    kind: PathModeKind
    tolerance_mm: float | None


class Message(NamedTuple):
    """Text for the person at the machine: ``(MSG, text)``."""

    place: TextPlace
    text: str


class End(NamedTuple):
    """End of the program: M2, M30."""

    place: TextPlace


Canonical = Straight | Arc | Dwell | Switch | Pause | PathMode | Message | End


class Settings(NamedTuple):
    """State of the machine that a program begins with.

    ``parameters`` are numbered as in RS-274/NGC: 5161 to 5169 are the home of G28, 5220 is the coordinate
    system, 5221 to 5229 its first one's offset, in the units of the machine: millimetres and degrees.
    """

    file: str = "program"
    position: Point = Point()
    parameters: Mapping[int, float] = {}
    is_block_delete: bool = False
    """True skips lines that begin with a slash."""


class Program(NamedTuple):
    """Motions, remarks and problems of a text in G-code.

    ``motions`` is empty if there is a problem: a program is whole or does not move. ``problems`` are in the
    order of the text. ``remarks`` tell what is read and does nothing here. ``understood``: the motions, in a
    program with problems those that are what they would be without them; for checks alone.
    """

    motions: tuple[Canonical, ...]
    problems: tuple[Problem, ...]
    remarks: tuple[Problem, ...] = ()
    line_count: int = 0
    understood: tuple[Canonical, ...] = ()
