"""Values of a drive, with their meanings; cells beside them, and their text."""

from collections.abc import Mapping
from math import isfinite

TOLD = {
    "position_deg": "angle of the shaft",
    "velocity_rpm": "speed of the shaft",
    "current_A": "current of the motor",
    "fault_code": "number of a fault; 0: none",
}
"""Values that a drive tells, with their meanings."""
TAKEN = {
    "set_point_deg": "target of a move, or the set-point that is followed",
    "set_velocity_rpm": "largest speed on the way to a target",
    "acceleration_rpm_per_s": "acceleration of the ramps on the way to a target",
}
"""Values that a drive takes, with their meanings."""
MORE_TOLD = {
    "commanded_deg": "set-point of the loop now; while it is off, the angle of the shaft",
    "following_error_deg": "distance of the shaft from the set-point of the loop",
    "turns": "whole turns of the shaft",
    "angle_deg": "angle of the shaft within the turn",
    "speed_rpm": "speed of the shaft without a sign",
    "ordered_rpm": "speed that was set",
}
"""Values that a drive tells by a map of version 2."""
MORE_TAKEN = {
    "deceleration_rpm_per_s": "deceleration of the ramps; never written: as the acceleration",
    "run_velocity_rpm": "speed to turn at, where it is another value than `set_velocity_rpm`",
    "homing_method": "way to search home, by the number of a homing method; never written: 21",
    "homing_velocity_rpm": "speed of the search for the switch; never written: `set_velocity_rpm`",
    "homing_slow_rpm": "speed at the edge and to the index; never written: a tenth of the other",
}
"""Values that a drive takes by a map of version 2."""
USUAL_HOMING, SLOWLY = 21, 0.1
"""Homing method, and the slow speed as a part of the fast one, of a drive to which none was written."""
CELL, STORED = "cell.", "stored."
"""Beginnings of the names by which a board tells its cells, and what of them is stored."""
MOST_TEXT = 16384
"""Maximum length of a text of cells: those of one request, and of one command."""


def cells_text(cells: Mapping[str, float]) -> str:
    """Text of cells with their values, as in ``current_A=1.5 mode=2``. Whole numbers keep all digits."""
    return " ".join(f"{name}={_number(value)}" for name, value in cells.items())


def is_finite(value: float) -> bool:
    """True of a number that is neither infinite nor none, however many digits it has."""
    return isinstance(value, int) or isfinite(value)


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else repr(value)


def cells_of(text: str) -> dict[str, float]:
    """Cells of a text of ``cells_text``. Raises ValueError: ``str(error)`` says what is wrong."""
    cells: dict[str, float] = {}
    for part in text.split():
        name, is_given, number = part.partition("=")
        if not name or not is_given:
            raise ValueError(f"{part[:40]!r} is no name=number, as in current=1.5")
        try:
            cells[name] = int(number) if number.lstrip("+-").isdecimal() else float(number)
        except ValueError:
            raise ValueError(f"{name}: {number[:40]!r} is no number") from None
        if not is_finite(cells[name]):
            raise ValueError(f"{name}: {number[:40]!r} is no number that can be used")
    return cells
