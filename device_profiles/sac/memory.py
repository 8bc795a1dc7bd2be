"""The SAC's non-volatile memory: the EEPROM's content, loaded at power-up and saved on command."""

from collections.abc import Callable, Mapping

from device_profiles.sac.eeprom import Eeprom, EepromError
from device_profiles.sac.terminal import Steps
from hil.vocab.firmware import Commit

MEMORY, ASIDE = "eeprom", "eeprom_damaged"
"""Sections: the EEPROM, and what could not be read when it was one."""


class Memory:
    """``eeprom`` is the content as commands see it; ``note`` tells the operator what was damaged."""

    def __init__(self, nvm: Mapping[str, bytes], note: Callable[[str, str | None], None]) -> None:
        self._nvm = nvm
        self._note = note
        self.eeprom = Eeprom()

    def load(self) -> Steps:
        """Read the EEPROM; keep one that cannot be read aside, and take the factory's settings."""
        stored = self._nvm.get(MEMORY)
        if stored is None:
            return
        try:
            self.eeprom = Eeprom.unpacked(stored)
        except EepromError as error:
            aside = next(name for n in range(1, 1000) if (name := f"{ASIDE}-{n}") not in self._nvm)
            self._note("eeprom", f"EEPROM: {error}; it was kept as {aside}, the factory's settings hold")
            if (yield Commit(aside, stored)):
                yield from self.save()

    def save(self) -> Steps:
        """Make the EEPROM durable. Where that fails the old content is what a read-back shows."""
        if not (yield Commit(MEMORY, self.eeprom.packed())):
            stored = self._nvm.get(MEMORY)
            self.eeprom = Eeprom.unpacked(stored) if stored else Eeprom()

    def stored(self) -> bytes:
        """The bytes that are durable, or would be."""
        return self._nvm.get(MEMORY, self.eeprom.packed())
