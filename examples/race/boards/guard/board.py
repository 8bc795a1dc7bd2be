"""Profile of the door guard."""

from hil.vocab.profile import Profile, UartSpec

from .firmware import Guard

PROFILE = Profile(firmware=Guard, uarts={"bus": UartSpec(about="reports, on RS485")})
