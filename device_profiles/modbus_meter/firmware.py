"""Program of the board: cells that a master writes, and that anybody sets from outside."""

from hil.firmware.cell_verbs import CELL_VERBS, put_verb
from hil.firmware.kept_cells import KeptCells
from hil.vocab.firmware import Board, CoreEvent, Delay, Main
from hil.vocab.time import NS_PER_MS

READY_NS, STEP_NS = 200 * NS_PER_MS, 20 * NS_PER_MS
"""Time from power-up until it takes cells, and from one step of ramps to the next."""


class ModbusMeter:
    """One power-up of the board."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self.cells = KeptCells(board.nvm, board.tell)
        self.cells.tell_all()

    @property
    def now_ns(self) -> int:
        """Simulated time."""
        return self._board.now_ns

    def main(self) -> Main:
        yield Delay(READY_NS)
        while True:
            if commit := self.cells.step(self.now_ns):
                yield commit
            yield Delay(STEP_NS)

    def interrupt(self, event: CoreEvent) -> None:
        return

    def must_be_ready(self) -> None:
        """Take cells at any time."""


VERBS = (*CELL_VERBS, put_verb())
