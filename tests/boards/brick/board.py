"""A board with nothing that hil models: no serial interface, no motor, no program."""

from hil.vocab.profile import Profile

PROFILE = Profile(uarts={})
