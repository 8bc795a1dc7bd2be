"""Profile of the Mechaduino."""

from device_profiles.mechaduino import dialogues, verbs
from device_profiles.mechaduino.firmware import Mechaduino
from device_profiles.mechaduino.lookup_table import TABLE_FILE
from device_profiles.mechaduino.own_sketch import with_sketch
from device_profiles.mechaduino.sessions import is_own_words, session_plan
from hil.vocab.firmware import MAIN
from hil.vocab.profile import Example, Profile, UartSpec

PROFILE = Profile(
    firmware=Mechaduino,
    sketch=with_sketch,
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
    examples=(
        Example(types=b"m", answer=b"Main menu\r\n", within_ms=1),
        Example(types=b"s", answer=b", raw encoder: ", within_ms=200),
        Example(types=b"xyr20\n", answer=b"Enter setpoint:\r\n20.00\r\n", within_ms=200),
        Example(types=b"p", answer=b"stepNumber: 1 , Angle: ", within_ms=200),
    ),
    memory_file=TABLE_FILE,
    session=session_plan,
    is_own_words=is_own_words,
)
