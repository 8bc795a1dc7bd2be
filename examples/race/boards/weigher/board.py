"""Profile of the scale."""

from hil.vocab.profile import Profile, UartSpec

from .firmware import Weigher

PROFILE = Profile(firmware=Weigher, uarts={"bus": UartSpec(about="reports, on RS485")})
