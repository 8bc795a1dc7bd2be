"""System commands of the SAC: ``$`` and a letter, and the configure screen.

Source: the SAC user manual, Configure and System Commands.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from device_profiles.sac import screens
from device_profiles.sac.eeprom import Memory
from device_profiles.sac.parameters import change
from device_profiles.sac.session import Session
from device_profiles.sac.terminal import Steps, Terminal
from device_profiles.sac.typed_text import Attributes, Text
from hil.vocab.motion import Motion


@dataclass(frozen=True)
class SystemCommands:
    """System commands, case-sensitive. Each ends all activity first. ``reset`` is what ``$R`` does."""

    motion: Motion
    session: Session
    terminal: Terminal
    memory: Memory
    reset: Callable[[], Steps]

    def run(self, text: Text) -> Steps | None:
        """Execute a command; ``text`` is what follows the ``$``."""
        self.motion.stop(None)
        session = self.session
        match text.take():
            case "C":
                return self._configure(text)
            case "E":
                self._show_eeprom()
            case "R":
                return self.reset()
            case "F":
                self._set_pulses(False)
            case "P":
                self._set_pulses(True)
            case "U":
                self._set_pulses(not session.default.is_pulses)
            case "H":
                session.is_crc_on = text.number() != 0
            case "K":
                session.is_ack_on = text.number() != 0
            case "L" if (number := text.number()) is not None:
                session.say(Attributes(is_linear=number != 0))
            case "O" if (number := text.number()) is not None:
                session.is_soft_ops_on = number != 0
                self.motion.report(session.is_soft_ops_on)
            case "n":
                session.is_throttle = not session.is_throttle
                self.motion.encoder_mode(session.is_throttle)
        return None

    def show_configuration(self) -> None:
        """Show the EEPROM's parameters, as the configure screen has them."""
        self.terminal.println(screens.configuration(self.memory.eeprom.parameters))

    def _set_pulses(self, is_pulses: bool) -> None:
        self.session.default = replace(self.session.default, is_pulses=is_pulses)

    def _show_eeprom(self) -> None:
        lines: Iterable[str] = screens.configuration(self.memory.eeprom.parameters)
        if self.session.is_debug:
            lines = screens.dump(self.memory.stored())
        self.terminal.println(lines)

    def _configure(self, text: Text) -> Steps | None:
        """Execute ``$C``: a letter and a value set a parameter; alone, it draws the screen at each edit."""
        if text.peek():
            return self.memory.save() if change(self.memory.eeprom.parameters, text) else None
        self.show_configuration()
        self.terminal.mode = self._edit_configuration
        return None

    def _edit_configuration(self, text: Text) -> Steps:
        if change(self.memory.eeprom.parameters, text):
            yield from self.memory.save()
            self.show_configuration()
