"""Program of a board around its processor: the bootloader when a client opens the port, then what the
processor's flash holds."""

from hil.firmware.bootloader import USUAL_BAUD, Bootloader, Steps
from hil.firmware.chip_memory import ChipMemory
from hil.vocab.firmware import Board, CoreEvent, Delay, EventAvailable, Main
from hil.vocab.time import NS_PER_S

KEEP_AGAIN_NS = 20_000_000
"""Time after which what a program has written meanwhile to its flash and EEPROM is kept, too."""
NO_CAUSE, POWER_ON, EXTERNAL = 0, 1, 2
"""Causes of a reset, as bits of MCUSR."""
WRITTEN = ("flash_written", "eeprom_written")
RUNS = "runs"
"""Topic of the note on what runs."""


class ProgrammedBoard:
    """One power-up of the board, or one reset by its port."""

    def __init__(self, board: Board) -> None:
        self._board, self._processor = board, board.processor
        self._baud = board.facts.get("bootloader_baud", USUAL_BAUD)
        """Speed of the bootloader that hil answers as; 0: the board has none."""
        self._memory = ChipMemory(board, self._processor, has_bootloader=bool(self._baud))
        self._memory.put_in()
        self._writes = 0
        """Number of bytes and pages that a program has written."""

    def main(self) -> Main:
        """Run the bootloader, if the port was opened, and then what is in the flash."""
        memory, is_opened = self._memory, self._board.started_by == "line"
        if not memory.is_kept:  # what a reset has cut short
            yield from memory.keep()
        cause = EXTERNAL if is_opened else POWER_ON
        if memory.has_bootloader:
            yield from self._run_chip(cause)
        if is_opened and self._baud:
            self._say("the bootloader")
            yield from self._bootloader().run()
        if not memory.program:
            yield from self._without_program()
        yield from self._run_chip(NO_CAUSE if self._baud else cause)  # the bootloader clears MCUSR

    def line_opened(self) -> bool:
        """Note that a client has opened the port. False: it is no reset."""
        return True

    def interrupt(self, event: CoreEvent) -> None:
        """Note what a program writes."""
        if event.kind in WRITTEN:
            self._writes += 1

    def _without_program(self) -> Steps:
        """Wait for a program, which a power-up or the opening of the port brings."""
        self._say("nothing: there is no program in the flash")
        while True:
            yield EventAvailable()

    def _bootloader(self) -> Bootloader:
        wall_second_ns = self._board.facts.get("wall_second_ns", NS_PER_S)
        return Bootloader(self._board, self._processor, wall_second_ns, self._memory.keep, self._baud)

    def _say(self, what: str) -> None:
        self._board.note(RUNS, f"runs {what}")

    def _run_chip(self, causes: int) -> Steps:
        """Let the processor run, for good, and keep what its program writes."""
        self._say(self._memory.title)
        self._processor.reset(causes, self._processor.start_up_cycles)
        self._processor.set_stack_floor(self._memory.heap_start)
        kept = 0
        while True:
            while self._writes == kept:
                yield EventAvailable()
            kept = self._writes
            yield from self._memory.keep()
            self._say(self._memory.title)
            yield Delay(KEEP_AGAIN_NS)
