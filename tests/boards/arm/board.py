"""Profile of the arm."""

from hil.vocab.profile import AxisSpec, Profile, UartSpec

from .firmware import Arm
from .verbs import VERBS, follow, starve

PROFILE = Profile(
    firmware=Arm,
    uarts={
        "main": UartSpec(about="console, over USB"),
        "logger": UartSpec(about="a line for each command"),
        "bus": UartSpec(about="answers to who asks on the bus"),
    },
    axes={"shoulder": AxisSpec(about="lifts the arm"), "elbow": AxisSpec(about="bends it")},
    verbs=VERBS,
    follow=follow,
    starve=starve,
)
