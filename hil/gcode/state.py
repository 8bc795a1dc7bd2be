"""State of a machine as a program changes it: where the axes are, offsets, modes and parameters."""

from math import sqrt
from typing import NamedTuple

from hil.gcode.canonical import Feed, FeedKind, Plane, Settings, SwitchName, SwitchState
from hil.gcode.words import AXES

MM_PER_INCH = 25.4
LINEAR = (0, 1, 2, 6, 7, 8)
"""Indices of X Y Z U V W."""

SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")

# Numbers of parameters: RS-274/NGC, table 2; 5210 and 5420 as in LinuxCNC 2.9.
HOME, SECOND_HOME = 5161, 5181
SHIFT_IS_ON, SHIFT = 5210, 5211
SYSTEM, ORIGIN, ORIGINS_APART = 5220, 5221, 20
HERE = 5420
READ_ONLY = range(5400, 5429)


class ArcTolerance(NamedTuple):
    """Limits of LinuxCNC 2.9, as measured with its interpreter, in millimetres."""

    radius_mm: float
    """Smaller radii count as 0, and a radius may be too short for the ends by this."""
    always_mm: float
    """Radii at both ends may differ by this."""
    share: float = 1e-3
    """They may differ by this share of the larger one, too."""
    never_mm: float = 0.0
    """They may never differ by more."""


TOLERANCE_MM = ArcTolerance(0.00127, 0.02 * sqrt(2), never_mm=2 * sqrt(2))
"""With G21."""

TOLERANCE_INCH = ArcTolerance(0.00127, 0.0508 * sqrt(2), never_mm=5.08 * sqrt(2))
"""With G20: 0.00005 inches, and twice the root of 2 in thousandths of an inch."""


class Units(NamedTuple):
    """Units of length: what one is in millimetres, what one of each axis is, what arcs may miss."""

    mm: float
    scale: tuple[float, ...]
    tolerance: ArcTolerance


MILLIMETRES = Units(1.0, (1.0,) * len(AXES), TOLERANCE_MM)
INCHES = Units(
    MM_PER_INCH,
    tuple(MM_PER_INCH if index in LINEAR else 1.0 for index in range(len(AXES))),
    TOLERANCE_INCH,
)


class ProgramState:
    """Everything that lines leave behind for those that follow.

    ``position`` is in machine coordinates, millimetres and degrees; so are ``origin`` (of the coordinate
    system), ``shift`` (of G92) and ``offset``, their sum.
    """

    def __init__(self, settings: Settings) -> None:
        self.numbers = {number: float(value) for number, value in settings.parameters.items()}
        self.names: dict[str, float] = {}
        self.position = list(settings.position)
        self.units = MILLIMETRES
        self.is_incremental = False
        self.is_arc_absolute = False
        self.plane: Plane = "xy"
        self.motion: str | None = None
        """``G0`` to ``G3``; None after G80."""
        self.feed_kind: FeedKind = "per_minute"
        self.feed = 0.0
        """As F gave it; 0 if none holds."""
        self.linear_feed = self.rotary_feed = Feed("per_minute", 0.0)
        self.spindle: SwitchState = "off"
        self.speed_rpm = 0.0
        self.coolants: list[SwitchName] = []
        """Those that are on, in the order in which they were switched on."""
        self.tool = 0
        self.system = 1
        self.origin = [0.0] * len(AXES)
        self.shift = [0.0] * len(AXES)
        self.offset = [0.0] * len(AXES)
        if self.numbers.get(SHIFT_IS_ON):
            self.shift_from_parameters()
        first = self.numbers.get(SYSTEM, 1.0)
        self.select(int(first) if 1 <= first <= len(SYSTEMS) else 1)

    def select(self, system: int) -> None:
        """Take coordinate system 1 to 9, with the origin that parameters give it."""
        self.system = system
        self.numbers[SYSTEM] = float(system)
        first = ORIGIN + ORIGINS_APART * (system - 1)
        self._offset_by([self.numbers.get(first + index, 0.0) for index in range(len(AXES))], self.shift)

    def set_origin(self, system: int, origins: dict[int, float]) -> None:
        """Store origins of axes, by index, for a coordinate system."""
        first = ORIGIN + ORIGINS_APART * (system - 1)
        self.numbers.update((first + index, value) for index, value in origins.items())
        if system == self.system:
            self.select(system)

    def set_shift(self, shift: list[float]) -> None:
        """Set the offsets of G92, and the parameters that keep them."""
        self._offset_by(self.origin, shift)
        self.numbers[SHIFT_IS_ON] = 1.0
        self.store(SHIFT, shift)

    def shift_off(self) -> None:
        """Switch the offsets of G92 off; parameters keep them."""
        self._offset_by(self.origin, [0.0] * len(AXES))
        self.numbers[SHIFT_IS_ON] = 0.0

    def shift_from_parameters(self) -> None:
        self.set_shift([self.numbers.get(SHIFT + index, 0.0) for index in range(len(AXES))])

    def store(self, first: int, values: list[float]) -> None:
        """Keep a value for each axis in the parameters from ``first`` on."""
        self.numbers.update((first + index, value) for index, value in enumerate(values))

    def set_feed(self, value: float) -> None:
        """Take F in the units of now."""
        self.feed = value
        is_time = self.feed_kind == "inverse_time"
        self.linear_feed = Feed(self.feed_kind, value if is_time else value * self.units.mm)
        self.rotary_feed = Feed(self.feed_kind, value)

    def numbered(self, number: int) -> float:
        """Value of a numbered parameter; 0 if nothing has set it."""
        if HERE <= number < HERE + len(AXES):
            return self._here(number - HERE)
        return self.numbers.get(number, 0.0)

    def named(self, name: str) -> float | None:
        """Value of a parameter with a name; None if there is none."""
        value = self._own(name)
        return self.names.get(name) if value is None else value

    def is_read_only(self, key: int | str) -> bool:
        return key in READ_ONLY if isinstance(key, int) else self._own(key) is not None

    def assign(self, key: int | str, value: float) -> None:
        if isinstance(key, int):
            self.numbers[key] = value
        else:
            self.names[key] = value

    def _here(self, index: int) -> float:
        return (self.position[index] - self.offset[index]) / self.units.scale[index]

    def _offset_by(self, origin: list[float], shift: list[float]) -> None:
        self.origin, self.shift = origin, shift
        self.offset = [one + other for one, other in zip(origin, shift, strict=True)]

    def _own(self, name: str) -> float | None:
        """Value of a parameter that the reader itself keeps, by the names of LinuxCNC."""
        match name.removeprefix("_") if name.startswith("_") else "":
            case letter if len(letter) == 1 and letter in AXES:
                return self._here(AXES.index(letter))
            case "metric":
                return float(self.units is MILLIMETRES)
            case "imperial":
                return float(self.units is INCHES)
            case "absolute":
                return float(not self.is_incremental)
            case "incremental":
                return float(self.is_incremental)
            case "inverse_time" | "units_per_minute" | "units_per_rev":
                kinds = {"inverse_time": "inverse_time", "units_per_minute": "per_minute"}
                return float(self.feed_kind == kinds.get(name[1:], "per_revolution"))
            case "feed":
                return self.feed
            case "rpm":
                return self.speed_rpm
            case _:
                return None
