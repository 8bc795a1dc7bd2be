"""Profile of the CANopen drive."""

from device_profiles.canopen_drive import verbs
from device_profiles.canopen_drive.firmware import CanOpenServo
from hil.vocab.profile import Profile

PROFILE = Profile(
    firmware=CanOpenServo,
    uarts={},
    verbs=verbs.VERBS,
    follow=verbs.follow,
    shown_first=(
        *("at_ns", "position_deg", "yw", "velocity_rpm", "torque_Nm"),
        *("loop_on", "mode", "r", "u", "following"),
    ),
)
