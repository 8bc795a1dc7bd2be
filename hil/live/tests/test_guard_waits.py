"""Steps that do not come back: those that sleep are a runaway's, those that are kept waiting are not."""

import ctypes
import gc
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hil.live.guard import FirmwareHung, StepGuard

BOARD: Any = SimpleNamespace(name="m1", now_ns=0)


@pytest.fixture
def guard(tmp_path: Path) -> Iterator[StepGuard]:
    made = StepGuard(tmp_path / "hung")
    try:
        yield made
    finally:
        made.close()


@pytest.mark.parametrize("sleep_s", [60.0, 0.03])
def test_a_step_that_sleeps_is_stopped(guard: StepGuard, sleep_s: float) -> None:
    def step() -> None:
        with guard(BOARD):
            for _ in range(200):
                time.sleep(sleep_s)

    with pytest.raises(FirmwareHung, match="waited for more than 200 ms"):
        step()


def test_a_guard_that_is_closed_leaves_the_next_ones_signal_alone(tmp_path: Path) -> None:
    """The next guard keeps its signal, whenever the closed one is freed."""
    before = StepGuard(tmp_path / "before")
    before.close()
    guard = StepGuard(tmp_path / "hung")
    del before
    gc.collect()
    try:
        with pytest.raises(FirmwareHung, match="waited for more than"), guard(BOARD):
            time.sleep(2)
    finally:
        guard.close()


def test_a_step_that_waits_for_the_interpreter_is_not_blamed(guard: StepGuard) -> None:
    """Another thread keeps the interpreter, as C code may, for longer than a step may sleep."""
    kept = threading.Event()

    def keep() -> None:
        ctypes.PyDLL(None).usleep(600_000)  # PyDLL keeps the interpreter's lock
        kept.set()

    with guard(BOARD):
        thread = threading.Thread(target=keep)
        thread.start()
        while not kept.is_set():
            sum(range(1000))
    thread.join()


def test_a_short_sleep_is_no_runaways(guard: StepGuard) -> None:
    for _ in range(10):
        with guard(BOARD):
            time.sleep(0.1)
