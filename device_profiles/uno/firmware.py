"""Program of the board: the bootloader when a client opens the port, then a sketch.

The sketch is what the processor's flash holds; where it holds none, hil's own in Python.
"""

from device_profiles.uno.step_dir_sketch import StepDirSketch
from device_profiles.uno.stepping import Steps
from hil.firmware.programmed_board import ProgrammedBoard
from hil.vocab.firmware import Board, CoreEvent


class Uno(ProgrammedBoard):
    """One power-up of the board, or one reset by its port."""

    def __init__(self, board: Board) -> None:
        super().__init__(board)
        self._sketch: StepDirSketch | None = None

    def line_opened(self) -> bool:
        """Note that a client has opened the port. False: it is no reset, as hil's own sketch runs."""
        if self._sketch:
            self._sketch.watch.open()
        return self._sketch is None

    def interrupt(self, event: CoreEvent) -> None:
        if self._sketch:
            self._sketch.interrupt(event)
        else:
            super().interrupt(event)

    def _without_program(self) -> Steps:
        """Run hil's own sketch, until a tool has uploaded another."""
        while not self._memory.program:
            self._sketch = StepDirSketch(self._board)
            self._say("hil's own sketch: there is no program in the flash")
            sent = yield from self._sketch.main()
            self._sketch = None
            self._say("the bootloader")
            yield from self._bootloader().listen(sent)
