"""A board without a motor: it answers each byte at its one serial interface."""

from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Main
from hil.vocab.profile import Profile


class Pinger:
    def __init__(self, board: Board) -> None:
        self._uart = board.uart

    def main(self) -> Main:
        while True:
            yield ByteAvailable()
            self._uart.read()
            self._uart.write(b"ping")

    def interrupt(self, event: CoreEvent) -> None:
        return


PROFILE = Profile(firmware=Pinger)
