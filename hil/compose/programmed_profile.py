"""Profile of boards that need no ``board.py``: their program is the one on their processor."""

from functools import lru_cache

from hil.firmware.programmed_board import ProgrammedBoard
from hil.vocab.profile import Profile, UartSpec


@lru_cache
def programmed_profile(uarts: tuple[str, ...]) -> Profile:
    """Profile of a board with serial interfaces of these names, whose program runs on its processor."""
    return Profile(
        firmware=ProgrammedBoard,
        uarts={name: UartSpec(about="serial interface of its program") for name in uarts},
        shown_first=("at_ns", "cycles", "pin_levels", "pins_driven"),
    )
