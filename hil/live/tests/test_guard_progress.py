"""Runaways of many short steps: how the guard tells them by its bells of CPU time."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hil.live.guard import PARTS, STEP_LIMIT_NS, FirmwareHung, StepGuard

BELL_NS = STEP_LIMIT_NS // PARTS


def condemned_after(tmp_path: Path, advance_ns: int, is_inside: bool, bells: int = 100) -> int | None:
    """Number of bells until the guard condemns a board that advances ``advance_ns`` between two of them; None
    if it does not."""
    guard: Any = StepGuard(tmp_path / "hung")
    try:
        board: Any = SimpleNamespace(name="m1", now_ns=0)
        guard(board)
        for number in range(bells):
            guard._steps, guard._inside = 50, is_inside
            try:
                guard._look_at_progress()
            except FirmwareHung:
                return number
            if guard._condemned is board:
                return number
            board.now_ns += advance_ns
        return None
    finally:
        guard._inside = False
        guard.close()


@pytest.mark.parametrize("part", [1.0, 0.9, 0.6])
def test_a_board_is_not_blamed_for_what_others_take(tmp_path: Path, part: float) -> None:
    assert condemned_after(tmp_path, round(part * BELL_NS), is_inside=False) is None


@pytest.mark.parametrize(("part", "is_inside"), [(0.0, True), (0.0, False), (0.3, False), (0.9, True)])
def test_a_board_that_gets_nowhere_is_stopped_at_the_limit(
    tmp_path: Path, part: float, is_inside: bool
) -> None:
    assert condemned_after(tmp_path, round(part * BELL_NS), is_inside) == PARTS
