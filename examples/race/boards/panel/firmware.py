"""Program of the panel: it stops the cell when a report of the door's guard is lost."""

import re

from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Main

_GUARD = re.compile(rb"G(\d{6})C")
_WEIGHT = re.compile(rb"W\d{5}g")
_LONGEST = 64


class Panel:
    """One power-up."""

    def __init__(self, board: Board) -> None:
        self._terminal, self._bus = board.uarts["terminal"], board.uarts["bus"]
        self._reports = 0

    def main(self) -> Main:
        """Read reports, line by line; what is typed at the terminal means nothing."""
        self._terminal.write(b"panel: the cell runs\r\n")
        line = b""
        while True:
            yield ByteAvailable()
            self._terminal.read_all()
            *lines, line = (line + self._bus.read_all())[-_LONGEST:].split(b"\n")
            for each in lines:
                self._hear(each)

    def _hear(self, line: bytes) -> None:
        if report := _GUARD.fullmatch(line):
            self._reports += 1
            if (number := int(report[1])) != self._reports:
                self._terminal.write(
                    f"panel: STOP, report {self._reports} of the guard is missing\r\n".encode()
                )
                self._reports = number
        elif not _WEIGHT.fullmatch(line):
            self._terminal.write(b"panel: cannot read " + line.hex().encode() + b"\r\n")

    def interrupt(self, event: CoreEvent) -> None:
        """Ignore the core's events: none means anything to this board."""
