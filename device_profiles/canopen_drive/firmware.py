"""Program of the drive: its loop, its ramps, and what makes it give up."""

from hil.firmware.closed_loop_drive import CURRENT, ENCODER, IDLE_NS, WATCH_NS, ClosedLoopDrive, DriveFault
from hil.firmware.set_point_paths import at
from hil.vocab.firmware import Delay, Main
from hil.vocab.path import DEG_PER_S, Path

POSITION, TORQUE = ord("x"), ord("t")


class CanOpenServo(ClosedLoopDrive):
    """One power-up of the drive. A following error is no fault of its own: its node has one."""

    def main(self) -> Main:
        yield from self._start()
        self.is_busy = False
        self._tell_all()
        while True:
            self._watch()
            yield Delay(WATCH_NS if self.is_on else IDLE_NS)

    # ---- what it is asked for ----

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
        super().clear_fault()
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

    def follow(self, path: Path, start_ns: int = 0) -> None:
        """Let the set-point follow a path, from a time or from now on."""
        self.axis.set("mode", POSITION)
        self.axis.follow(path, start_ns)
        self._path, self._path_from_ns = path, max(start_ns, self._now_ns)

    @property
    def target_deg(self) -> float:
        """Angle at which a move that is under way will end, or the set-point."""
        return self._path[-1].r if self.axis.get("following") else self._where()[0]

    # ---- what it does by itself ----

    def _watch(self) -> None:
        """Look for faults, and tell how it does."""
        if self.is_on and (fault := self._fault()):
            self.switch_off()
            self.fault_code = fault.code
            self._note("fault", f"fault {fault.code}: {fault.about}")
        self._tell_all()

    def _fault(self) -> DriveFault | None:
        if self._encoder_fails():
            return ENCODER
        return CURRENT if self._lacks_current() else None

    def _tell_all(self) -> None:
        self._tell("fault_code", self.fault_code)
        self._tell("fault", self.fault_code != 0)
        self._tell("position_deg", None if self.is_on else self.here_deg())

    def _hold_at(self, position_deg: float) -> None:
        self.axis.set("mode", POSITION)
        self.axis.set("r", position_deg)

    def _where(self) -> tuple[float, float]:
        """Set-point and its rate in degrees a second; under an effort alone the shaft's."""
        if self.axis.get("mode") != POSITION:
            return self.here_deg(), self.axis.get("velocity_rpm") * DEG_PER_S
        if self.axis.get("following"):
            return at(self._path, self._now_ns - self._path_from_ns)
        return self.axis.get("r"), 0.0
