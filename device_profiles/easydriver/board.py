"""Profile of the EasyDriver. It has no firmware: its pins are all that it has."""

from device_profiles.easydriver.reversal import says
from hil.vocab.profile import Profile

PROFILE = Profile(
    uarts={},
    says=says,
    shown_first=(
        *("at_ns", "position_deg", "velocity_rpm", "torque_Nm", "commanded_deg", "lag_steps", "lost_steps"),
        *("microsteps", "outputs_on", "reversal_us", "most_steps_Hz", "timing_errors"),
    ),
)
