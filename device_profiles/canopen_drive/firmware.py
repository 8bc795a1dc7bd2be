"""Program of the drive: its loop, its ramps, and what makes it give up."""

import math
from array import array
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

from hil.firmware.set_point_paths import at, length_ns, to_rest, trapezoid
from hil.vocab.firmware import Board, CoreEvent, Delay, Main
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
POSITION, TORQUE = ord("x"), ord("t")


class ServoFault(NamedTuple):
    """Fault of the drive, which takes the current off until it is cleared. Its number is that of the boards
    whose nodes know it; a following error is the node's own."""

    code: int
    about: str


ENCODER = ServoFault(2, "the encoder reports an error")
CURRENT = ServoFault(3, "no current in the motor: no supply, driver too hot, or both coils open")
FAULTS = {fault.code: fault for fault in (ENCODER, CURRENT)}


class CanOpenServo:
    """One power-up of the drive."""

    def __init__(self, board: Board) -> None:
        self.axis = board.axis
        self._tell, self._note = board.tell, board.note
        self.is_busy = True
        """True while it starts."""
        self.fault_code = 0
        self._path: Path = ()
        self._path_from_ns = self._current_ns = 0

    def main(self) -> Main:
        self.axis.vref(0, 0)  # what drives the pins after power-up would pull the shaft
        self.axis.write_table(_identity_table())
        yield Delay(READY_NS)
        self.axis.spi(READ_ANGLE)  # the next answer belongs to this
        self.is_busy = False
        self._tell_all()
        while True:
            self._watch()
            yield Delay(WATCH_NS if self.is_on else IDLE_NS)

    def interrupt(self, event: CoreEvent) -> None:
        return

    # ---- what it is asked for ----

    @property
    def is_on(self) -> bool:
        """True if the loop is on."""
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
            about = FAULTS[self.fault_code].about
            raise VerbRefused("not_now", f"fault {self.fault_code}, {about}; clear it first")

    def must_be_ready(self) -> None:
        """Refuse while the drive starts."""
        if self.is_busy:
            raise VerbRefused("not_now", "the drive starts; wait until it is ready")

    def switch_on(self) -> None:
        """Hold the shaft where it is."""
        if not self.is_on:
            self._hold_at(self.here_deg())
            self.axis.loop(True)
        self._current_ns = 0

    def switch_off(self) -> None:
        """Take the current off."""
        self.axis.loop(False)
        self.axis.vref(0, 0)

    def clear_fault(self) -> None:
        """Clear a fault; the loop stays off."""
        if self.fault_code == ENCODER.code:
            self.axis.spi(READ_ERRORS)
            self.axis.spi(READ_ANGLE)
        self.fault_code = 0
        self._note("fault", None)
        self._tell_all()

    def hold(self) -> None:
        """Hold the shaft where it is."""
        self._hold_at(self.here_deg())

    def step_to(self, position_deg: float) -> None:
        """Go to a set-point at once."""
        self._hold_at(position_deg)

    def push(self, effort_count: float) -> None:
        """Give the motor an effort, whatever the shaft does."""
        self.axis.set("mode", TORQUE)
        self.axis.set("r", effort_count)

    def move(self, target_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float) -> Path:
        """Go to an angle on ramps, from what it does now. Raises VerbRefused."""
        limits = velocity_rpm * DEG_PER_S, acceleration_rpm_per_s * DEG_PER_S
        return self._along(lambda: trapezoid(*self._where(), target_deg, *limits))

    def ramp_down(self, acceleration_rpm_per_s: float) -> Path:
        """Stop on a ramp. Raises VerbRefused: it would take centuries."""
        return self._along(lambda: to_rest(*self._where(), acceleration_rpm_per_s * DEG_PER_S))

    def follow(self, path: Path, start_ns: int = 0) -> None:
        """Let the set-point follow a path, from a time or from now on."""
        self.axis.set("mode", POSITION)
        self.axis.follow(path, start_ns)
        self._path, self._path_from_ns = path, max(start_ns, self._now_ns)

    @property
    def target_deg(self) -> float:
        """Angle at which a move that is under way will end, or the set-point."""
        return self._path[-1].r if self.axis.get("following") else self._where()[0]

    def here_deg(self) -> float:
        """Angle of the shaft with turns, of a reading now, as the law's next step will count it."""
        angle_deg, turns = self.axis.get("raw") * 360.0 / COUNTS, self.axis.get("wrap_count")
        since_deg = angle_deg - (self.axis.get("yw") - 360.0 * turns)
        if abs(since_deg) > 180.0:
            turns -= math.copysign(1.0, since_deg)
        return angle_deg + 360.0 * turns

    # ---- what it does by itself ----

    def _watch(self) -> None:
        """Look for faults, and tell how it does."""
        if self.is_on and (fault := self._fault()):
            self.switch_off()
            self.fault_code = fault.code
            self._note("fault", f"fault {fault.code}: {fault.about}")
        self._tell_all()

    def _fault(self) -> ServoFault | None:
        axis = self.axis
        if axis.spi(READ_ANGLE) & ERROR:
            return ENCODER
        current_A = math.hypot(axis.get("current_a_A"), axis.get("current_b_A"))
        is_without = abs(axis.get("u")) >= EFFORT_COUNTS and current_A < CURRENT_A
        self._current_ns = self._current_ns + WATCH_NS if is_without else 0
        return CURRENT if self._current_ns >= NO_CURRENT_NS else None

    def _tell_all(self) -> None:
        self._tell("fault_code", self.fault_code)
        self._tell("fault", self.fault_code != 0)
        self._tell("position_deg", None if self.is_on else self.here_deg())

    def _hold_at(self, position_deg: float) -> None:
        self.axis.set("mode", POSITION)
        self.axis.set("r", position_deg)

    @property
    def _now_ns(self) -> int:
        return int(self.axis.get("at_ns"))

    def _where(self) -> tuple[float, float]:
        """Set-point and its rate in degrees a second; under an effort alone the shaft's."""
        if self.axis.get("mode") != POSITION:
            return self.here_deg(), self.axis.get("velocity_rpm") * DEG_PER_S
        if self.axis.get("following"):
            return at(self._path, self._now_ns - self._path_from_ns)
        return self.axis.get("r"), 0.0

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
