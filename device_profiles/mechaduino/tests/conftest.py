"""Fixtures of the tests of verbs. Their helpers are in ``mechaduino_board.py``."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out

from mechaduino_board import Board


@pytest.fixture
def board() -> Iterator[Board]:
    made = Board()
    yield made
    made.bench.close()


@pytest.fixture
def on(board: Board) -> Board:
    """Board whose loop holds the shaft."""
    board.do("enable")
    board.run(500)
    return board
