"""Parts of the arm as the firmware has them built in: names, pins, addresses, gears."""

from dataclasses import dataclass

SAMPLE_MS, SERVO_MS = 20, 56
"""Periods of the joints' drive laws, of servos and knob."""


@dataclass(frozen=True)
class StepperPart:
    """Geared stepper with its encoder. ``amps`` is only printed."""

    number: int
    name: str
    gear_ratio: float
    microsteps: int
    pins: tuple[int, int, int]
    """Pins EN, DIR, CLK."""
    amps: float
    i2c_bus: int
    i2c_address: int
    is_encoder_clockwise: bool
    offset_deg: float

    @property
    def label(self) -> str:
        return f"{self.name}({self.number})"


@dataclass(frozen=True)
class ServoPart:
    """HerkuleX servo."""

    number: int
    name: str
    servo_id: int
    start_counts: int
    """Position when the arm is built."""
    limits_torque: bool

    @property
    def label(self) -> str:
        return f"{self.name}({self.number})"


_UPPERARM_GEAR, _FOREARM_GEAR, _ELBOW_GEAR, _WRIST_GEAR = (
    72 / 14 * 48 / 14,
    60 / 14 * 48 / 15,
    49 / 16 * 34 / 14,
    65 / 15,
)
STEPPERS = (
    StepperPart(0, "hip", 90 / 10, 8, (6, 5, 4), 2.8, 1, 0x40, False, 0.0),
    StepperPart(1, "upperarm", _UPPERARM_GEAR, 8, (9, 8, 7), 3.5, 0, 0x43, True, 0.0),
    StepperPart(2, "forearm", _FOREARM_GEAR, 8, (12, 11, 10), 1.4, 0, 0x42, True, 90.0),
    StepperPart(3, "ellbow", _ELBOW_GEAR, 4, (27, 26, 25), 0.7, 0, 0x41, False, 0.0),
    StepperPart(4, "wrist", _WRIST_GEAR, 8, (30, 29, 28), 0.4, 0, 0x40, True, 0.0),
)
SERVOS = (ServoPart(5, "hand", 0xFD, 638, False), ServoPart(6, "gripper", 0xFC, 614, True))
PARTS: tuple[StepperPart | ServoPart, ...] = (*STEPPERS, *SERVOS)
LIGHTS_BUS, LIGHTS_ADDRESS = 1, 0x54
TORQUE_LIMIT_COUNTS = 704
DRIVE_IN_MS_PER_DEG = 1000.0 / 30.0
