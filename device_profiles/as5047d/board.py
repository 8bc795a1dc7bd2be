"""Profile of the AS5047D. It has no firmware: frames over SPI are all that it has."""

from hil.vocab.profile import Profile

PROFILE = Profile(uarts={}, shown_first=("at_ns", "raw", "diaagc", "errfl", "spi_frames"))
