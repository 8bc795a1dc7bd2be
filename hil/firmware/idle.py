"""Program of a board that has none of its own."""

from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Main


class Idle:
    """Program that does nothing: it drops what comes. ``hil.vocab.firmware.Firmware``."""

    def __init__(self, board: Board) -> None:
        self._uarts = board.uarts

    def main(self) -> Main:
        while True:
            yield ByteAvailable()
            for uart in self._uarts.values():
                uart.read_all()

    def interrupt(self, event: CoreEvent) -> None:
        return
