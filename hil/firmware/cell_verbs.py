"""Verbs of boards with cells of a map: from outside, and as a master writes them."""

from typing import Protocol

from hil.firmware.kept_cells import KeptCells
from hil.vocab.drive_words import MOST_TEXT
from hil.vocab.parameters import Parameter
from hil.vocab.time import NS_PER_S
from hil.vocab.verbs import Verb


class WithCells(Protocol):
    """Program of a board with cells."""

    cells: KeptCells

    @property
    def now_ns(self) -> int:
        """Simulated time."""

    def must_be_ready(self) -> None:
        """Raise VerbRefused while it starts."""


def set_cells(board: WithCells, values: str, over_s: float = 0.0) -> None:
    """Set cells from outside, at once or on ramps. Raises VerbRefused."""
    board.must_be_ready()
    board.cells.take_text(values, board.now_ns, round(over_s * NS_PER_S))


def store(board: WithCells, names: str = "") -> None:
    """Store cells."""
    board.cells.store(names.split())


def put_cells(board: WithCells, cells: str = "") -> None:
    """Take cells as a master writes them. Raises VerbRefused."""
    board.must_be_ready()
    board.cells.take_text(cells, board.now_ns)


CELLS = Parameter("cells", "cells, as in current=1.5 mode=2", maximum=MOST_TEXT, default="", is_text=True)
CELL_VERBS = (
    Verb(
        "cells",
        "set cells of the map, at once or on ramps from what was set before",
        (
            Parameter(
                "values",
                "cells with values, as in voltage_V=231.5 power_W=0",
                maximum=MOST_TEXT,
                is_text=True,
            ),
            Parameter("over_s", "duration of the ramps", "s", 0.0, 1e6, 0.0),
        ),
        set_cells,
    ),
    Verb(
        "store",
        "store cells, so that they are the same after the next power-up",
        (Parameter("names", "names of cells", maximum=MOST_TEXT, default="", is_text=True),),
        store,
    ),
)


def put_verb(*others: Parameter) -> Verb:
    """Verb of a write by a map of version 2, of a board with cells alone."""
    return Verb(
        "put", "write cells by a map of version 2, as a Modbus master does", (CELLS, *others), put_cells
    )
