"""Bells that ring in the guard's own code, at the edges of a step."""

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any

import pytest

from hil.live.guard import PARTS, FirmwareHung, StepGuard

BOARD: Any = SimpleNamespace(name="m1", now_ns=0)


class Watchdog:
    """Watchdog whose bells are all rung: each step has taken too much."""

    is_in_step = False

    def enter(self, name: bytes) -> None:
        self.is_in_step = True

    def leave(self) -> bool:
        self.is_in_step = False
        return False

    def bells(self) -> int:
        return PARTS + 1

    def bells_in_work(self) -> tuple[int, int]:
        return PARTS + 1, 0


@pytest.fixture
def guard(tmp_path: Path) -> Iterator[Any]:
    guard: Any = StepGuard(tmp_path / "hung")
    guard.close()
    guard._watchdog = Watchdog()
    yield guard
    signal.signal(signal.SIGVTALRM, signal.SIG_IGN)


@contextmanager
def bell_in(guard: Any, function: Callable[..., Any], event: str) -> Iterator[None]:
    """Ring once, at an event of a function's call."""

    def ring(frame: FrameType, kind: str, _: object) -> None:
        if kind == event and frame.f_code is function.__code__:
            sys.setprofile(None)
            guard._ring(signal.SIGVTALRM, frame)

    sys.setprofile(ring)
    try:
        yield
    finally:
        sys.setprofile(None)


@pytest.mark.parametrize("event", ["call", "return"])
def test_a_bell_in_the_step_s_end_does_not_leave_the_guard_on(guard: Any, event: str) -> None:
    """It did: the next bell, at any later place of the daemon, ended that."""
    with bell_in(guard, StepGuard.__exit__, event), guard(BOARD):
        pass
    assert not guard._inside
    assert not guard._watchdog.is_in_step
    guard._ring(signal.SIGVTALRM, None)  # strikes nobody


def test_a_bell_in_the_step_s_end_keeps_what_struck_it(guard: Any) -> None:
    with pytest.raises(FirmwareHung), bell_in(guard, StepGuard.__exit__, "call"), guard(BOARD):
        guard._ring(signal.SIGVTALRM, sys._getframe())
    assert not guard._inside


def test_a_bell_in_the_step_s_beginning_does_not_leave_the_guard_on(guard: Any) -> None:
    with bell_in(guard, StepGuard.__enter__, "return"), guard(BOARD):
        pass
    assert not guard._inside
    assert not guard._watchdog.is_in_step


def test_a_bell_in_the_step_strikes(guard: Any) -> None:
    with pytest.raises(FirmwareHung), guard(BOARD):
        guard._ring(signal.SIGVTALRM, sys._getframe())
    assert not guard._inside
