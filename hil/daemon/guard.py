"""Interrupts a firmware step that burns too much CPU time, so that one device's bug stops only it.

A native timer raises SIGVTALRM each time this thread has burnt a part of what a step may; a step that
sees too many of them gets ``FirmwareHung`` from the signal's Python handler, in the middle of whatever the
firmware does. A stopped process or a stolen CPU does not count, and a step costs no system call.
"""

import signal
from contextlib import AbstractContextManager
from types import FrameType, TracebackType

from hil.core._native import Watchdog

STEP_LIMIT_NS = 200_000_000
"""CPU time of one step, up to half as much again. The longest of a healthy firmware, a query of the look-up
table, takes 20 ms."""
PARTS = 2


class FirmwareHung(BaseException):
    """A firmware step used more CPU time than a step may. No ``Exception``: a firmware that goes on after
    whatever happens to it must not go on after this."""


class StepGuard(AbstractContextManager[None]):
    """A context for one step; make it once, in the main thread, and close it: a bell that rings while Python
    ends would kill the process."""

    def __init__(self, limit_ns: int = STEP_LIMIT_NS) -> None:
        self._limit_ns = limit_ns
        self._inside = False
        self._rung = 0
        self._watchdog = Watchdog(signal.SIGVTALRM)
        signal.signal(signal.SIGVTALRM, self._ring)
        self._watchdog.arm(limit_ns // PARTS)

    def __enter__(self) -> None:
        self._rung = 0
        self._inside = True

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._inside = False

    def close(self) -> None:
        """No more bells."""
        self._watchdog.disarm()

    def __call__(self) -> "StepGuard":
        return self

    def _ring(self, number: int, frame: FrameType | None) -> None:
        # A signal that comes just after the step must not hit whoever runs then.
        if self._inside:
            self._rung += 1
            if self._rung > PARTS:  # the first came before a whole part of the step
                raise FirmwareHung(f"one step took more than {self._limit_ns // 1_000_000} ms of CPU time")
