"""A board of one's own in handlers instead of a main loop: what comes at its UARTs, and what time brings."""

from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Main


class BoardHandlers:
    """Program of a board: ``hil.vocab.firmware.Firmware``. Override ``setup``, ``received``, ``tick`` and
    ``interrupt`` as far as the board has them. None of them takes simulated time."""

    TICK_NS: int | None = None
    """Time between two calls of ``tick``; None: there are none."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self.fields = board.fields

    def setup(self) -> None:
        """Begin: the board has just got its power."""

    def received(self, uart: str, data: bytes) -> None:
        """Take bytes that have come at a UART, by its name. They are as many as came together."""

    def tick(self) -> None:
        """Do what is due each ``TICK_NS`` since the start: the first time after one of them."""

    def interrupt(self, event: CoreEvent) -> None:
        """Handle an interrupt, at its own time."""

    def main(self) -> Main:
        """Call the handlers, at the times at which they are due."""
        self.setup()
        due_ns = self.board.now_ns + (self.TICK_NS or 0)
        while True:
            left_ns = max(0, due_ns - self.board.now_ns)
            yield ByteAvailable(timeout_ns=left_ns if self.TICK_NS else None)
            for name, uart in self.board.uarts.items():
                if data := uart.read_all():
                    self.received(name, data)
            while self.TICK_NS and self.board.now_ns >= due_ns:
                due_ns += self.TICK_NS
                self.tick()
