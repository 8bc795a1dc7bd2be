"""Program of the door guard: a report each two seconds, when nobody else talks."""

from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Delay, Main
from hil.vocab.time import NS_PER_MS, NS_PER_S

QUIET_NS = NS_PER_MS
"""Silence after which the line is free: almost four characters."""
SWITCH_ON_NS = 60_000
"""Time that its driver takes to switch on."""


class Guard:
    """One power-up."""

    def __init__(self, board: Board) -> None:
        self._bus = board.uart

    def main(self) -> Main:
        """Report that the door is closed, each two seconds."""
        count = 0
        while True:
            yield Delay(2 * NS_PER_S)
            yield from self._wait_for_silence()
            yield Delay(SWITCH_ON_NS)
            count += 1
            self._bus.write(f"G{count:06}C\n".encode())

    def _wait_for_silence(self) -> Main:
        self._bus.read_all()
        while (yield ByteAvailable(timeout_ns=QUIET_NS)):
            self._bus.read_all()

    def interrupt(self, event: CoreEvent) -> None:
        """Ignore the core's events: none means anything to this board."""
