"""Interrupts a firmware step that burns too much CPU time, so that one device's bug stops only it.

A native timer on this thread's CPU time raises SIGVTALRM; its Python handler raises ``FirmwareHung``
in the middle of whatever the firmware does. A stopped process or a stolen CPU does not count.
"""

import signal
from contextlib import AbstractContextManager
from types import FrameType, TracebackType

from hil.core._native import Watchdog

STEP_LIMIT_NS = 200_000_000
"""CPU time of one step. The longest of a healthy firmware, a query of the look-up table, takes 20 ms."""


class FirmwareHung(BaseException):
    """A firmware step used more CPU time than a step may. No ``Exception``: a firmware that goes on after
    whatever happens to it must not go on after this."""


class StepGuard(AbstractContextManager[None]):
    """A context for one step; make it once, in the main thread."""

    def __init__(self, limit_ns: int = STEP_LIMIT_NS) -> None:
        self._limit_ns = limit_ns
        self._inside = False
        self._watchdog = Watchdog(signal.SIGVTALRM)
        signal.signal(signal.SIGVTALRM, self._expired)

    def __enter__(self) -> None:
        self._inside = True
        self._watchdog.arm(self._limit_ns)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._inside = False
        self._watchdog.disarm()

    def __call__(self) -> "StepGuard":
        return self

    def _expired(self, number: int, frame: FrameType | None) -> None:
        # A signal that comes just after the step must not hit whoever runs then.
        if self._inside:
            raise FirmwareHung(f"one step took more than {self._limit_ns // 1_000_000} ms of CPU time")
