"""Profile of the Uno."""

from device_profiles.uno.firmware import Uno
from hil.vocab.firmware import MAIN
from hil.vocab.profile import Example, Profile, UartSpec

PROFILE = Profile(
    firmware=Uno,
    uarts={MAIN: UartSpec(about="commands, over the board's USB adapter")},
    shown_first=("at_ns", "pulses_sent", "pulses_left", "pin_levels", "pins_driven"),
    examples=(
        Example(types=b"move 16\n", answer=b"moved 16 steps\r\n", within_ms=100),
        Example(types=b"pin 8 1\npin 8\n", answer=b"pin 8 is 1\r\n", within_ms=100),
        Example(types=b"jump\n", answer=b"error: ", within_ms=100),
    ),
)
