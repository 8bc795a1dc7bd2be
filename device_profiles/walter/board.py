"""Profile of Walter's Cortex."""

from device_profiles.walter import verbs
from device_profiles.walter.arm_parts import SERVOS, STEPPERS
from device_profiles.walter.cortex_commands import OWN_WORDS
from device_profiles.walter.firmware import LOGGER, PRINTER, SERVO, Cortex
from device_profiles.walter.sessions import session_plan
from hil.vocab.firmware import MAIN
from hil.vocab.profile import AxisSpec, Example, Profile, UartSpec

PROFILE = Profile(
    firmware=Cortex,
    uarts={
        MAIN: UartSpec(about="commands"),
        LOGGER: UartSpec(about="texts of the firmware, out only"),
        SERVO: UartSpec(about="packets of the HerkuleX servos"),
        PRINTER: UartSpec(about="thermal printer"),
    },
    axes={part.name: AxisSpec(about=f"the {part.name}, a geared stepper") for part in STEPPERS}
    | {part.name: AxisSpec(about=f"the {part.name}, a servo") for part in SERVOS},
    shown_first=(
        "at_ns",
        "position_deg",
        "measured_deg",
        "to_be_deg",
        "velocity_rpm",
        "is_enabled",
        "joint_pulses",
    ),
    verbs=verbs.VERBS,
    starve=verbs.starve,
    session=session_plan,
    is_own_words=lambda line: line in OWN_WORDS,
    examples=(
        Example(types=b"INFO\r", answer=b" setuped i2c0=(0x40,0x41,0x42,0x43) i2c1=(0x40,0x54)>ok\r\n>"),
        Example(types=b"ECHO hello\r", answer=b"hello>ok\r\n>", within_ms=10),
    ),
)
