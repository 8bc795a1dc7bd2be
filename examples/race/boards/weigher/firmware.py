"""Program of the scale: a weight when it has settled, when nobody else talks."""

from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Delay, Main
from hil.vocab.time import NS_PER_MS

QUIET_NS = NS_PER_MS
"""Silence after which the line is free: almost four characters."""
SWITCH_ON_NS = 60_000
"""Time that its driver takes to switch on."""


class Weigher:
    """One power-up. A bag settles in 3.5 to 4.5 s, as the goods swing: here a sequence of numbers that is
    always the same."""

    def __init__(self, board: Board) -> None:
        self._bus = board.uart
        self._swing = 5

    def main(self) -> Main:
        """Report a weight each time that it has settled."""
        while True:
            self._swing = self._swing * 48271 % 0x7FFFFFFF  # Park and Miller's minimal standard
            yield Delay(3500 * NS_PER_MS + self._swing % (1000 * NS_PER_MS))
            self._bus.read_all()
            while (yield ByteAvailable(timeout_ns=QUIET_NS)):
                self._bus.read_all()
            yield Delay(SWITCH_ON_NS)
            self._bus.write(f"W{self._swing % 2000:05}g\n".encode())

    def interrupt(self, event: CoreEvent) -> None:
        """Ignore the core's events: none means anything to this board."""
