"""Sketch that moves a stepper: its main loop prints the lines of boot, and reads commands."""

from collections.abc import Generator
from typing import Any

from device_profiles.uno.stepping import Stepping, Steps
from device_profiles.uno.tool_watch import ToolWatch
from device_profiles.uno.typed_commands import carry_out
from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Request

MOST_CHARACTERS = 40
"""Length of a line; a longer one is dropped as a whole."""
LINE_ENDS = b"\r\n"
PRINTED = range(0x20, 0x7F)
"""Characters that a line may have."""


class StepDirSketch:
    """One run of the sketch."""

    def __init__(self, board: Board) -> None:
        self._uart = board.uart
        self._stepping = Stepping(board)
        self.watch = ToolWatch()
        self._line, self._wrong = bytearray(), ""

    def main(self) -> Generator[Request, Any, bytes]:
        """Run the sketch's setup() and loop(), until a tool begins to upload. Returns what that has sent."""
        self._stepping.set_up()
        self._stepping.print_boot()
        self._stepping.begin_by_itself()
        while True:
            yield ByteAvailable(self._stepping.swing_in_ns)
            self._stepping.swing_on()
            typed, sent = self.watch.sift(self._uart.read_all())
            if sent:
                self._stepping.end_all()
                return sent
            for byte in typed:
                yield from self._take(byte)

    def interrupt(self, event: CoreEvent) -> None:
        if event.kind == "pulses_ended":
            self._stepping.end()

    def _take(self, byte: int) -> Steps:
        if byte in LINE_ENDS:
            yield from self._end_line()
        elif byte not in PRINTED:
            self._wrong = self._wrong or f"byte 0x{byte:02X} is no text"
        elif len(self._line) == MOST_CHARACTERS:
            self._wrong = self._wrong or f"a line has at most {MOST_CHARACTERS} characters"
        else:
            self._line.append(byte)

    def _end_line(self) -> Steps:
        words, wrong = self._line.decode("ascii").split(), self._wrong
        self._line, self._wrong = bytearray(), ""
        if wrong:
            self._stepping.say(f"error: {wrong}; send the line again")
        elif words:
            yield from carry_out(self._stepping, words)
