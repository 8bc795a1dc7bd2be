"""What the daemon does with a real SAC, over its terminal, where it has a verb for the same with a twin."""

from device_profiles.sac.companion import Terminal
from hil.vocab.dialogue import Dialogue


def reset() -> Dialogue[None]:
    """The warm reset: parameters from the EEPROM come into force, the queue stays."""
    terminal = Terminal()
    yield from terminal.sync()
    yield from terminal.ask("$R")


DIALOGUES = {"reset": reset}
