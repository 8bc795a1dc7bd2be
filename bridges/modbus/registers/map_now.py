"""State of a drive, or of a board without an axis, in the words of its map: values, cells, conditions."""

from collections.abc import Mapping
from math import floor, hypot, isfinite

from bridges.modbus.registers import control_states
from bridges.modbus.registers.map_entries import MapEntries, MapRow
from bridges.modbus.registers.map_parts import CIA402, CellPart, CommandPart, StatePart
from hil.vocab.axis import TURNS_RPM
from hil.vocab.desk_protocol import AxisLook
from hil.vocab.drive_words import CELL, SLOWLY, STORED, USUAL_HOMING
from hil.vocab.packed_fields import value_at

MODE = "mode"
"""Name of the command whose number is the mode."""
HOMING, ASKED, DONE = "homing.word", 1, 2
"""Cell that says whether `home` was asked for, and whether it had arrived before the next motion."""
_SAME = {
    "deceleration_rpm_per_s": "acceleration_rpm_per_s",
    "run_velocity_rpm": "set_velocity_rpm",
    "homing_velocity_rpm": "set_velocity_rpm",
    "ordered_rpm": "set_velocity_rpm",
}
"""Values that are as others until they are written."""
_LIMITS = {"negative_limit": "pin_dir", "positive_limit": "pin_step"}
"""Fields of the inputs D0 and D1."""
_NEAR, _NEAR_RPM = 0.03, 2.0
"""Part of a speed, and speed, within which it counts as reached."""


class MapNow:
    """State at one time. ``look``: None where nothing is told."""

    def __init__(self, of: MapEntries, look: AxisLook | None) -> None:
        self._of, self._look = of, look
        self._parts = of.of.parts
        self._told: Mapping[str, float] = look.told if look else {}

    def kept(self, name: str) -> float:
        """Content of a cell or of a command, as a master reads it back."""
        if (value := self._told.get(CELL + name)) is not None:
            return value
        if name in self._parts.cells:
            return self._parts.cells[name][1].default
        return self._parts.commands[name][1].default if name in self._parts.commands else 0

    def cell(self, name: str) -> float:
        """Value of a cell that is in effect."""
        if name in self._parts.cells and self._parts.cells[name][1].waits:
            return self._told.get(STORED + name, self._parts.cells[name][1].default)
        return self.kept(name)

    @property
    def mode(self) -> str:
        """Meaning of the mode: one of ``MODES``."""
        row = self._parts.commands.get(MODE)
        if row:
            return row[1].sets_mode.get(int(self.kept(MODE)), "")
        return "absolute" if self._of.of.has_angle else "velocity"

    @property
    def origin_deg(self) -> float:
        """Angle of the shaft that its registers call 0."""
        return self._told.get("origin_deg", 0.0)

    def number(self, row: MapRow) -> float:
        """Value of a row that a master may read."""
        part = row.part
        if isinstance(part, CellPart):
            return self.kept(row.name)
        if isinstance(part, CommandPart):
            return self.kept(row.name) if part.is_kept else 0
        if isinstance(part, StatePart):
            return self._state(part)
        if row.room == "parameter":
            return self._field(row.name)
        return self.told(row.name)

    def _state(self, part: StatePart) -> int:
        if part.standard == CIA402:
            return control_states.status_word(self)
        held = (number for condition, number in part.numbers if self.holds(condition))
        return next(held, part.otherwise)

    def told(self, name: str) -> float:
        """Value or bit of the drive by its name."""
        if name in ("position_deg", "set_point_deg", "commanded_deg", "turns", "angle_deg"):
            return self._angle(name)
        name = _SAME.get(name, name) if name not in self._told else name
        if name in self._told:
            return self._told[name]
        if name == "homing_method":
            return USUAL_HOMING
        if name == "homing_slow_rpm":
            return self.told("homing_velocity_rpm") * SLOWLY
        look = self._look
        if name == "fault":
            return float(look is not None and look.failed is not None)
        if look is None:
            return 0.0
        said = look.motion
        if name == "current_A":
            return hypot(self._field("current_a_A"), self._field("current_b_A"))
        if name == "following_error_deg":
            return said.off_by_deg if said.is_on else 0.0
        if name in ("speed_rpm", "velocity_rpm"):
            velocity_rpm = self._field("velocity_rpm")
            stands = abs(velocity_rpm) <= TURNS_RPM and bool(said.is_on) and not said.is_moving
            return 0.0 if stands else abs(velocity_rpm) if name == "speed_rpm" else velocity_rpm
        if name in ("enabled", "moving"):
            return float(bool(said.is_on if name == "enabled" else said.is_moving))
        return self._field(name)

    def _angle(self, name: str) -> float:
        said = self._look.motion if self._look else None
        here_deg = self._told.get("position_deg", said.position_deg if said else None) or 0.0
        if name == "set_point_deg":
            return self._told.get(name, 0.0) - self.origin_deg
        if name == "commanded_deg":
            commanded_deg = said.commanded_deg if said and said.is_on else here_deg
            return (here_deg if commanded_deg is None else commanded_deg) - self.origin_deg
        angle_deg = here_deg - self.origin_deg
        if name == "turns":
            return floor(angle_deg / 360)
        return angle_deg % 360.0 if name == "angle_deg" else angle_deg

    def holds(self, condition: str) -> bool:
        """True if a condition of ``CONDITIONS`` holds."""
        is_fault = bool(self.told("fault"))
        is_on, moves = bool(self.told("enabled")), bool(self.told("moving"))
        if condition in ("fault", "sound"):
            return is_fault == (condition == "fault")
        if condition == "ready":
            return not is_fault and not is_on
        if condition in ("enabled", "disabled"):
            return is_on == (condition == "enabled")
        if condition in ("moving", "standing"):
            return moves == (condition == "moving")
        if condition == "arrived":
            return is_on and not moves
        if condition == "running":
            return bool(self._told.get("running", 0))
        if condition == "reversed":
            return bool(self._told.get("reverse", 0))
        if condition == "homed" and (asked := self.kept(HOMING)):
            return asked == DONE or (is_on and not moves)
        if condition in ("homing", "homed", "home_missed"):
            return bool(self._told.get(condition, 0))
        if condition == "stored":
            return all(self._is_stored(name) for name in self._parts.cells)
        if condition == "home_switch":
            return "pin_d3" in self._of.info.fields and not self._field("pin_d3")
        if condition in _LIMITS:
            return bool(self._field(_LIMITS[condition]))
        velocity_rpm = self.told("velocity_rpm")
        if condition == "backward":
            return velocity_rpm < -TURNS_RPM or (
                abs(velocity_rpm) <= TURNS_RPM and bool(self._told.get("reverse", 0))
            )
        set_rpm = abs(self._told.get("running_rpm", self._told.get("set_velocity_rpm", 0.0)))
        return moves and abs(abs(velocity_rpm) - set_rpm) <= max(_NEAR * set_rpm, _NEAR_RPM)

    def _is_stored(self, name: str) -> bool:
        part = self._parts.cells[name][1]
        return part.keeps != "by_command" or self.kept(name) == self._told.get(STORED + name, part.default)

    def _field(self, name: str) -> float:
        if self._look is None or (field := self._of.info.fields.get(name)) is None:
            return 0.0
        value = value_at(self._look.packed, field.type, field.offset)
        return value if isfinite(value) else 0.0
