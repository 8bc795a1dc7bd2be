"""Profile of the Mechaduino."""

from device_profiles.mechaduino import dialogues, verbs
from device_profiles.mechaduino.firmware import Mechaduino
from device_profiles.mechaduino.lookup_table import TABLE_FILE
from hil.vocab.firmware import MAIN
from hil.vocab.profile import Profile, UartSpec

PROFILE = Profile(
    firmware=Mechaduino,
    uarts={MAIN: UartSpec(about="menu, over USB")},
    verbs=verbs.VERBS,
    starve=verbs.starve,
    follow=verbs.follow,
    dialogues={"enable": dialogues.enable, "disable": dialogues.disable},
    terminal_axis=dialogues.RunAxis,
    shown_first=(
        *("at_ns", "position_deg", "yw", "velocity_rpm", "torque_Nm"),
        *("loop_on", "mode", "r", "u", "following"),
    ),
    memory_file=TABLE_FILE,
)
