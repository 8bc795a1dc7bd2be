"""Profile of the Modbus drive."""

from device_profiles.modbus_drive import verbs
from device_profiles.modbus_drive.firmware import ModbusDrive
from hil.vocab.profile import Profile

PROFILE = Profile(
    firmware=ModbusDrive,
    uarts={},
    verbs=verbs.VERBS,
    starve=verbs.starve,
    follow=verbs.follow,
    shown_first=(
        *("at_ns", "position_deg", "yw", "velocity_rpm", "torque_Nm"),
        *("loop_on", "mode", "r", "u", "following"),
    ),
)
