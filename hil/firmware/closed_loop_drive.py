"""Shared program of servo drives with a closed loop: start, refusals, faults, ramps."""

import math
from abc import ABC, abstractmethod
from array import array
from collections.abc import Callable, Iterator
from functools import cache
from typing import NamedTuple

from hil.firmware.set_point_paths import length_ns, to_rest, trapezoid
from hil.vocab.firmware import Board, CoreEvent, Delay
from hil.vocab.path import DEG_PER_S, Path
from hil.vocab.time import NS_PER_MS
from hil.vocab.verbs import VerbRefused

COUNTS, READ_ANGLE, READ_ERRORS, ERROR = 16384, 0xFFFF, 0x4001, 0x4000
"""Counts of a turn, frames that read them and the error register, which is cleared then, and the flag of an
error in an answer (AS5047D's data sheet)."""
READY_NS = 200 * NS_PER_MS
WATCH_NS, IDLE_NS = NS_PER_MS, 10 * NS_PER_MS
"""Time from one look at the axis to the next: with the loop on, and off."""
EFFORT_COUNTS, CURRENT_A, NO_CURRENT_NS = 40.0, 0.02, 50 * NS_PER_MS
"""No current: less than this while the loop asks for so much, 0.34 A, for so long."""


class DriveFault(NamedTuple):
    """Fault of a drive, which takes the current off until it is cleared."""

    code: int
    about: str


ENCODER = DriveFault(2, "the encoder reports an error")
CURRENT = DriveFault(3, "no current in the motor: no supply, driver too hot, or both coils open")


class ClosedLoopDrive(ABC):
    """One power-up of a drive, whose faults beside ``ENCODER`` and ``CURRENT`` are ``others``."""

    def __init__(self, board: Board, *others: DriveFault) -> None:
        self.axis = board.axis
        self._tell, self._note = board.tell, board.note
        self.is_busy = True
        """True while it starts."""
        self.fault_code = 0
        self._faults = {fault.code: fault for fault in (*others, ENCODER, CURRENT)}
        self._path: Path = ()
        self._path_from_ns = self._current_ns = 0

    def _start(self) -> Iterator[Delay]:
        """Start, until the encoder can be read."""
        self.axis.vref(0, 0)  # what drives the pins after power-up would pull the shaft
        self.axis.write_table(_identity_table())
        yield Delay(READY_NS)
        self.axis.spi(READ_ANGLE)  # the next answer belongs to this

    def interrupt(self, event: CoreEvent) -> None:
        return

    # ---- what it is asked for ----

    @property
    def is_on(self) -> bool:
        """True if the loop is on and holds the shaft."""
        return bool(self.axis.get("loop_on"))

    def must_be_on(self) -> None:
        """Refuse a motion while the drive starts, has a fault, or its loop is off."""
        self.must_be_sound()
        if not self.is_on:
            raise VerbRefused("not_now", "the control loop is off; enable it first")

    def must_be_sound(self) -> None:
        """Refuse while the drive starts or has a fault."""
        self.must_be_ready()
        if self.fault_code:
            about = self._faults[self.fault_code].about
            raise VerbRefused("not_now", f"fault {self.fault_code}, {about}; clear it first")

    def must_be_ready(self) -> None:
        """Refuse while the drive starts."""
        if self.is_busy:
            raise VerbRefused("not_now", "the drive starts; wait until it is ready")

    def clear_fault(self) -> None:
        """Clear a fault; the loop stays off."""
        if self.fault_code == ENCODER.code:
            self.axis.spi(READ_ERRORS)
            self.axis.spi(READ_ANGLE)
        self.fault_code = 0
        self._note("fault", None)

    def move(self, target_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float) -> Path:
        """Go to an angle by the drive's own ramps, from what it does now. Raises VerbRefused."""
        limits = velocity_rpm * DEG_PER_S, acceleration_rpm_per_s * DEG_PER_S
        return self._along(lambda: trapezoid(*self._where(), target_deg, *limits))

    def ramp_down(self, acceleration_rpm_per_s: float) -> Path:
        """Stop on a ramp. Raises VerbRefused: it would take centuries."""
        return self._along(lambda: to_rest(*self._where(), acceleration_rpm_per_s * DEG_PER_S))

    @abstractmethod
    def follow(self, path: Path, start_ns: int = 0) -> None:
        """Let the set-point follow a path, from a time or from now on."""

    def here_deg(self) -> float:
        """Angle of the shaft with turns, of a reading now, as the law's next step will count it."""
        angle_deg, turns = self.axis.get("raw") * 360.0 / COUNTS, self.axis.get("wrap_count")
        since_deg = angle_deg - (self.axis.get("yw") - 360.0 * turns)
        if abs(since_deg) > 180.0:
            turns -= math.copysign(1.0, since_deg)
        return angle_deg + 360.0 * turns

    # ---- what the kinds of drives are made of ----

    def _encoder_fails(self) -> bool:
        return bool(self.axis.spi(READ_ANGLE) & ERROR)

    def _lacks_current(self) -> bool:
        """Look at the current once in ``WATCH_NS``; True if it has been missing for too long."""
        axis = self.axis
        current_A = math.hypot(axis.get("current_a_A"), axis.get("current_b_A"))
        is_without = abs(axis.get("u")) >= EFFORT_COUNTS and current_A < CURRENT_A
        self._current_ns = self._current_ns + WATCH_NS if is_without else 0
        return self._current_ns >= NO_CURRENT_NS

    @property
    def _now_ns(self) -> int:
        return int(self.axis.get("at_ns"))

    @abstractmethod
    def _where(self) -> tuple[float, float]:
        """Angle at which a new path begins, and its rate in degrees a second."""

    def _along(self, make: Callable[[], Path]) -> Path:
        try:
            path = make()
            self.follow(path)
        except (ValueError, OverflowError):
            why = f"no path leads there from the set-point {self.axis.get('r'):g}; set another one first"
            raise VerbRefused("not_now", why) from None
        return path


def duration_of(path: Path) -> dict[str, float | str | int]:
    """Answer of a verb that began a path."""
    return {"ends_after_ns": length_ns(path), "set_point": path[-1].r}


@cache
def _identity_table() -> bytes:
    """Table of an encoder that is mounted without an error."""
    return array("f", [count * 360 / COUNTS for count in range(COUNTS)]).tobytes()
