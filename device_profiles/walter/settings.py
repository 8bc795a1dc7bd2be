"""Settings of the arm, and the EEPROM that keeps a part of them."""

import math
from dataclasses import dataclass, field, fields
from struct import Struct

from device_profiles.walter.arm_parts import SAMPLE_MS, STEPPERS
from device_profiles.walter.float32 import f32

SECTION = "eeprom"
MARK = 1583
"""Word at address 0 of an EEPROM that was written."""
_SERVO_TYPE, _STEPPER_TYPE = 0, 1
_HEAD = Struct("<?????3x")
_STEPPER = Struct("<BB2xB3xfB3x7fii")
_SERVO = Struct("<BB2xB3xfff32x")
_MARK = Struct("<H")
_IMAGE_BYTES = _HEAD.size + 5 * _STEPPER.size + 2 * _SERVO.size
KEPT_BYTES = _IMAGE_BYTES & 0xFF
"""Bytes that are kept: the length of the image is in 8 bits."""


@dataclass
class LogFlags:
    """Classes of text on the logger."""

    setup: bool = True
    servo: bool = False
    stepper: bool = False
    encoder: bool = False
    loop: bool = True


@dataclass
class Setting:
    """Setting of an actuator, in float32; a servo has the first three alone."""

    min_deg: float
    max_deg: float
    null_deg: float
    speed_rpm: float = 0.0
    acceleration_rpm_per_s: float = 0.0
    kP: float = 0.0
    kI: float = 0.0
    kD: float = 0.0

    def __post_init__(self) -> None:
        for each in fields(self):
            setattr(self, each.name, f32(getattr(self, each.name)))


def stock_settings() -> list[Setting]:
    """Make the settings of all actuators as the firmware has them built in."""
    return [
        Setting(-90, 90, 143, 100, 700, 0.4),
        Setting(-90, 90, 107, 140, 1000, 0.5),
        Setting(-180, 34, 210.6, 150, 1000, 0.3),
        Setting(-91, 91, 21.9, 270, 10000, 0.5),
        Setting(-100, 90, -58.1, 140, 3000, 0.55),
        Setting(-120, 120, 41),
        Setting(0, 75, 33),
    ]


@dataclass
class ArmMemory:
    """Settings that the firmware keeps in its memory, and some of them in the EEPROM."""

    log: LogFlags = field(default_factory=LogFlags)
    actuators: list[Setting] = field(default_factory=stock_settings)

    def reset(self) -> None:
        """Put all back to what is built in."""
        self.log, self.actuators[:] = LogFlags(), stock_settings()

    def image(self) -> bytes:
        """Image of it as it lies in the board's memory."""
        flags = (getattr(self.log, each.name) for each in fields(LogFlags))
        return _HEAD.pack(*flags) + b"".join(map(_packed, range(len(self.actuators)), self.actuators))

    def kept(self) -> bytes:
        """Content of the EEPROM."""
        return _MARK.pack(MARK) + self.image()[:KEPT_BYTES]

    def read(self, eeprom: bytes) -> str | None:
        """Take over what an EEPROM keeps. Returns None, or what is wrong with it: then all that is built in
        stays, as the board does it where the mark is missing. Another version's data behind the right mark
        would let the board do anything; they are left out, too."""
        if eeprom[: _MARK.size] != _MARK.pack(MARK):
            return "it has no mark"
        kept = eeprom[_MARK.size : _MARK.size + KEPT_BYTES]
        if len(kept) < KEPT_BYTES:
            return f"it has {len(kept)} of {KEPT_BYTES} bytes"
        image = kept + self.image()[KEPT_BYTES:]
        if any(byte > 1 for byte in image[:5]):
            return "its log flags are none"
        actuators = []
        for number, part in enumerate(STEPPERS[:2]):
            at = _HEAD.size + number * _STEPPER.size
            kind, one, two, null, three, high, low, p, d, i, acceleration, speed, rate, micro = (
                _STEPPER.unpack(image[at : at + _STEPPER.size])
            )
            if (kind, one, two, three) != (_STEPPER_TYPE, number, number, number):
                return f"actuator {number} is no {part.name}"
            if (rate, micro) != (SAMPLE_MS, part.microsteps):
                return f"the {part.name} has {rate} ms and {micro} micro-steps"
            values = (low, high, null, speed, acceleration, p, i, d)
            if not all(map(math.isfinite, values)):
                return f"a number of the {part.name} is none"
            actuators.append(Setting(*values))
        self.log = LogFlags(*_HEAD.unpack(image[: _HEAD.size]))
        self.actuators[:2] = actuators
        return None


def _packed(number: int, of: Setting) -> bytes:
    if number >= len(STEPPERS):
        return _SERVO.pack(_SERVO_TYPE, number, number, of.null_deg, of.max_deg, of.min_deg)
    return _STEPPER.pack(
        *(_STEPPER_TYPE, number, number, of.null_deg, number, of.max_deg, of.min_deg),
        *(of.kP, of.kD, of.kI, of.acceleration_rpm_per_s, of.speed_rpm),
        *(SAMPLE_MS, STEPPERS[number].microsteps),
    )
