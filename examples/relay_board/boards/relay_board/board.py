"""Profile of Board relay_board."""

from hil.vocab.profile import Example, Profile

from .firmware import RelayBoard

PROFILE = Profile(
    firmware=RelayBoard,
    shown_first=("at_ns", "temperature_degC", "heater", "fan"),
    examples=(
        Example(types=b"heater 1\r", answer=b"ok\r\n", within_ms=100),
        Example(types=b"?\r", answer=b"21.0 heater 1 fan 0\r\n", within_ms=100),
    ),
)
