"""The EEPROM's late save: ten seconds after the latest change, with a line that nobody has asked for."""

from collections.abc import Generator, Mapping
from typing import Any

from device_profiles.walter.board_loop import Steps, due_ms, is_due
from device_profiles.walter.settings import SECTION, ArmMemory
from hil.vocab.firmware import Commit, Request, Uart

LATE_MS = 10_000


class LateSave:
    """EEPROM of the board, with what is to be saved."""

    def __init__(self, nvm: Mapping[str, bytes], uart: Uart) -> None:
        self._nvm, self._uart = nvm, uart
        self.memory = ArmMemory()
        self._since_ms: int | None = None

    def load(self) -> str | None:
        """Read what is stored. Returns None, or what is wrong with it: the board goes on with what is built
        in."""
        return self.memory.read(self._nvm.get(SECTION, b""))

    def save(self) -> Generator[Request, Any, bool]:
        """Write now; a save that was to come is dropped. Returns whether it is durable."""
        self._since_ms = None
        return bool((yield Commit(SECTION, self.memory.kept())))

    def begin(self, now_ms: int) -> None:
        """Note a change."""
        self._since_ms = now_ms

    def due_ms(self, now_ms: int) -> int | None:
        """Time in ms at which it will be due; None: there is nothing to save."""
        return None if self._since_ms is None else due_ms(now_ms, self._since_ms, LATE_MS)

    def step(self, pass_ms: int) -> Steps:
        """Save, and say so if that has gone, if it is due in the pass that began at this time."""
        is_over = self._since_ms is not None and is_due(pass_ms, self._since_ms, LATE_MS)
        if is_over and (yield from self.save()):
            self._uart.write(b"EEPROM saved.\r\n")
