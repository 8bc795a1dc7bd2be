"""Firmware with a sketch of the user's own beside the stock one: its setup() and loop(), controller and step
interrupt."""

from collections.abc import Callable, Mapping

from device_profiles.mechaduino.firmware import Mechaduino
from device_profiles.mechaduino.serial_usb import Steps
from device_profiles.mechaduino.sketch_board import SketchBoard
from hil.firmware.sketch_waits import Hook, SketchProgram, SketchWaits, call, interrupt, main
from hil.vocab.firmware import Board, CoreEvent, Main

HOOKS = {"control": ("controller", "own_law"), "step": ("step_interrupt", "own_step")}
"""Functions of a sketch that interrupts call, by their events, with the servo's call that lets it."""


class SketchedMechaduino(Mechaduino):
    """One power-up of the firmware with a sketch."""

    def __init__(self, program: SketchProgram, board: Board) -> None:
        super().__init__(board)
        self._board, self._waits = board, SketchWaits()
        self._face = SketchBoard(self, board, self._waits, self.check_serial)
        self._hooks = program.hooks()
        self._begin()
        for name, lets in HOOKS.values():
            if name in self._hooks:
                board.servo.do(lets, 1)

    def main(self) -> Main:
        return main(self._board, self._face, self._waits, self._hooks, self.boot, self._ready)

    def interrupt(self, event: CoreEvent) -> None:
        name, _ = HOOKS.get(event.kind, ("", ""))
        if name:
            interrupt(self._hooks[name], self._face, name)
        else:
            super().interrupt(event)

    def _ready(self) -> None:
        self.is_busy = False

    def check_serial(self, own: Mapping[str, Hook]) -> Steps:
        """Carry out one command, if one has come: the sketch's own, or the stock firmware's."""
        if not self.serial.available():
            return
        letter = self.serial.read()
        self.is_busy, self.letter = True, chr(letter)
        if hook := own.get(chr(letter)):
            yield from call(hook, self._face, self._waits)
        else:
            yield from self.command(letter)
        self.is_busy = False


def with_sketch(file: str, text: str) -> Callable[[Board], SketchedMechaduino]:
    """Make the maker of a firmware with a sketch. ``file``: its name, for messages; ``text``: is Python."""
    program = SketchProgram(file, compile(text, file, "exec", dont_inherit=True))
    return lambda board: SketchedMechaduino(program, board)
