"""Profile of the door guard with its second program."""

from hil.vocab.profile import Profile, UartSpec

from .firmware import Guard2

PROFILE = Profile(firmware=Guard2, uarts={"bus": UartSpec(about="reports, on RS485")})
