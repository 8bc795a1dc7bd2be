"""Interrupts a firmware that takes all the time there is, so that one device's bug stops only it.

A native timer raises SIGVTALRM each time this thread has used a part of the CPU time that a step may take.
While a firmware runs, it also does so for each part of the wall's time that a step may wait. A step that
sees too many of them gets ``FirmwareHung`` from the signal's Python handler, in the middle of whatever the
firmware does; so does one of many short steps that get nowhere. A stopped process or a stolen CPU does not
count, and a step costs no system call. Code that Python cannot interrupt ends the process; the native handler
writes down whose it was.
"""

import logging
import os
import resource
import signal
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import FrameType, TracebackType
from typing import NoReturn

from hil.core._native import Watchdog
from hil.sim.firmware_guard import FirmwareHung, Guarded

log = logging.getLogger("hil")

STEP_LIMIT_NS = 200_000_000
"""Maximum CPU time of one step, up to a quarter more. The longest of a healthy firmware, a query of the
look-up table, takes 20 ms."""
PARTS = 4
BREADCRUMB = "hung"
"""Name of the breadcrumb file in the bench's state directory; no device's file has this name."""
WAIT_LIMIT_NS = 200_000_000
"""Maximum wall time of a step in which the thread gave the CPU away of its own accord after each bell, and
used next to none: one that does not get a CPU, or is stopped, is not suspected."""
WAIT_CPU_SHARE = 0.05
"""Maximum CPU share of a waiting step: a healthy one that shares the interpreter with other threads uses
more, up to a load of 20."""
LONG_WAITS = 5
"""Limits for a waiting step that does not hear each bell: another thread may keep the interpreter."""
FEW_STEPS = 10
"""Minimum number of short steps in a part of the limit: fewer are long, as a client has asked for much."""
PATIENCE = 10
"""Limits for steps that are not short and get nowhere: 16 queries of the look-up table at once take 2."""


@dataclass
class _Waiting:
    """State of a step since its first bell of the wall's time."""

    heard: int
    waits: int
    cpu_s: float


class StepGuard(AbstractContextManager[None]):
    """Guard of firmware: ``with guard(device):`` around each step; make it once, in the main thread, and
    close it: a bell that rings while Python ends would kill the process. ``speed``: simulated seconds in one.
    ``breadcrumb``: the file that names the device whose firmware could not be interrupted."""

    def __init__(self, breadcrumb: Path, speed: float = 1.0, limit_ns: int = STEP_LIMIT_NS) -> None:
        self._limit_ns = limit_ns
        self._breadcrumb = breadcrumb
        # A bench that is to be faster than real time may be late; a slower one never catches up.
        self._least_ns = limit_ns // PARTS * min(speed, 1.0)
        self._names: dict[str, bytes] = {}
        self._device: Guarded | None = None
        self._inside = False
        self._aside = _Aside(self)
        self._struck: FirmwareHung | None = None
        self._steps = 0
        self._bells = 0
        self._waiting = _Waiting(0, 0, 0.0)
        self._suspect: Guarded | None = None
        self._suspected_at_ns = 0
        self._streak = 0.0
        self._condemned: Guarded | None = None
        signal.signal(signal.SIGVTALRM, self._ring)
        self._watchdog = Watchdog(signal.SIGVTALRM, os.fsencode(breadcrumb))
        self._watchdog.arm(limit_ns // PARTS, WAIT_LIMIT_NS // PARTS)

    def __call__(self, device: Guarded) -> "StepGuard":
        self._device = device
        return self

    def __enter__(self) -> None:
        device = self._device
        assert device is not None
        name = self._names.get(device.name)
        if name is None:
            name = self._names[device.name] = device.name.encode()
        self._steps += 1
        self._struck = None
        self._watchdog.enter(name)
        self._inside = True
        if device is self._condemned:
            self._condemned = None
            self._inside = False
            self._watchdog.leave()
            raise FirmwareHung(self._slow())

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._inside = False
        if self._watchdog.leave():  # it could be interrupted after all
            with suppress(OSError):
                self._breadcrumb.unlink()
        struck, self._struck = self._struck, None
        if struck and error is not struck:  # the firmware went on after it
            raise struck

    def aside(self) -> "_Aside":
        """Exclude work that is not the firmware's: its cost is not on the firmware's account."""
        return self._aside

    def close(self) -> None:
        self._watchdog.close()

    def _ring(self, number: int, frame: FrameType | None) -> None:
        bells = self._watchdog.bells()
        is_cpu, self._bells = bells != self._bells, bells
        # A signal that comes just after the step must not hit whoever runs then; and one that raised in the
        # guard's own code would leave it on, to hit whoever runs at the next.
        is_edge = frame is not None and frame.f_code in _EDGES
        if self._inside and not is_edge:
            cpu, wall = self._watchdog.bells_in_work()
            if cpu > PARTS:  # the first came before a whole part of the step
                self._strike(f"one step took more than {self._limit_ns // 1_000_000} ms of CPU time")
            if wall:
                self._look_at_wait(wall)
        if is_cpu and not self._aside.is_on and not is_edge:
            self._look_at_progress()

    def _strike(self, why: str) -> NoReturn:
        self._struck = FirmwareHung(why)
        raise self._struck

    def _look_at_wait(self, bells: int) -> None:
        usage = resource.getrusage(resource.RUSAGE_THREAD)
        cpu_s = usage.ru_utime + usage.ru_stime
        if bells == 1:
            self._waiting = _Waiting(1, usage.ru_nvcsw, cpu_s)
            return
        waiting = self._waiting
        waiting.heard += 1
        waits, used_s = usage.ru_nvcsw - waiting.waits, cpu_s - waiting.cpu_s
        is_asleep = (
            waiting.heard == bells
            and waits >= bells - 1
            and used_s < WAIT_CPU_SHARE * (bells - 1) * WAIT_LIMIT_NS / PARTS / 1e9
        )
        if bells > PARTS * (1 if is_asleep else LONG_WAITS) and waits >= PARTS - 1:
            ms = WAIT_LIMIT_NS * (1 if is_asleep else LONG_WAITS) // 1_000_000
            self._strike(f"one step has waited for more than {ms} ms")

    def _look_at_progress(self) -> None:
        """Check at a CPU bell that the stepping device has advanced in simulated time since the last."""
        device, steps = self._device, self._steps
        self._steps = 0
        if device is None or (steps == 0 and not self._inside):
            self._suspect = None
            return
        now_ns = device.now_ns
        # Where ports keep the thread busy, a healthy board comes just as far as its CPU time goes: that alone
        # is no fault, unless the bell rang in the board's own work.
        least_ns = self._least_ns if self._inside else self._least_ns / 2
        if device is not self._suspect or now_ns - self._suspected_at_ns >= least_ns:
            self._suspect, self._streak = device, 0
        else:
            self._streak += 1 if steps >= FEW_STEPS else 1 / PATIENCE
        self._suspected_at_ns = now_ns
        if self._streak >= PARTS:
            self._suspect = None
            if self._inside:
                self._strike(self._slow())
            self._condemned = device

    def _slow(self) -> str:
        return (
            f"its steps took {self._limit_ns // 1_000_000} ms of CPU time"
            " and did not come as far in simulated time"
        )


_EDGES = {StepGuard.__enter__.__code__, StepGuard.__exit__.__code__}
"""Code of the guard that runs while a step counts as begun."""


class _Aside(AbstractContextManager[None]):
    """Exclusion of work from a guard; it does not nest."""

    def __init__(self, guard: StepGuard) -> None:
        self._guard = guard
        self._was_inside = False
        self.is_on = False

    def __enter__(self) -> None:
        guard = self._guard
        self._was_inside, guard._inside = guard._inside, False
        self.is_on = True
        if self._was_inside:
            guard._watchdog.aside()

    def __exit__(self, *_: object) -> None:
        self.is_on = False
        if self._was_inside:
            self._guard._watchdog.resume()
            self._guard._inside = True


def note_hung(file: Path, notes: dict[str, str]) -> None:
    """Tell the operator of the device whose firmware ended the daemon the last time."""
    with suppress(OSError, UnicodeDecodeError):
        hung = file.read_text()
        file.unlink()
        if hung:
            notes[hung] = "its firmware could not be interrupted, which ended this bench the last time"
            log.error("%s: %s", hung, notes[hung])
