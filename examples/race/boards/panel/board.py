"""Profile of the panel."""

from hil.vocab.profile import Profile, UartSpec

from .firmware import Panel

PROFILE = Profile(
    firmware=Panel,
    uarts={
        "terminal": UartSpec(about="what happens in the cell"),
        "bus": UartSpec(about="reports, on RS485; it never sends"),
    },
)
