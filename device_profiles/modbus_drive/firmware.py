"""Program of the drive: its loop, its ramps, and what makes it give up."""

from hil.firmware.closed_loop_drive import CURRENT, ENCODER, IDLE_NS, WATCH_NS, ClosedLoopDrive, DriveFault
from hil.firmware.set_point_paths import at
from hil.vocab.firmware import Board, Delay, Main
from hil.vocab.path import DEG_PER_S, Path
from hil.vocab.time import NS_PER_MS

FOLLOWING_DEG, FOLLOWING_NS = 30.0, 50 * NS_PER_MS
"""Following error that is too large, once it has lasted so long."""
CHANGES_NS = 50 * NS_PER_MS
"""Time after a followed set-point for which the drive says that it moves."""
VELOCITY_RPM, ACCELERATION_RPM_PER_S = 60.0, 600.0
"""Speed and acceleration of moves, from power-up until others are written."""
BITS = ("enable", "start", "stop", "reset", "follow")
FOLLOWING = DriveFault(1, f"{FOLLOWING_DEG:g} deg off the set-point for {FOLLOWING_NS // NS_PER_MS} ms")


class ModbusDrive(ClosedLoopDrive):
    """One power-up of the drive."""

    def __init__(self, board: Board) -> None:
        super().__init__(board, FOLLOWING)
        self.set_point_deg = 0.0
        """Value of the register: the target of a move, the last set-point that was followed."""
        self.velocity_rpm, self.acceleration_rpm_per_s = VELOCITY_RPM, ACCELERATION_RPM_PER_S
        self.bits = dict.fromkeys(BITS, 0)
        """Control bits as they were written last."""
        self.is_streamed = False
        """True while set-points come one after the other."""
        self.has_new_target = False
        """True if a master has written another set-point since the last start."""
        self.repeats_start = False
        """True if a master has written the start bit again since, as one does that writes in a cycle."""
        self._changed_ns = self._following_ns = 0

    def main(self) -> Main:
        yield from self._start()
        self.set_point_deg = self.here_deg()
        self.is_busy = False
        self.tell()
        while True:
            self._watch()
            yield Delay(WATCH_NS if self.is_on else IDLE_NS)

    # ---- what it is asked for ----

    @property
    def is_following(self) -> bool:
        """True if set-points that are written are followed at once."""
        return bool(self.bits["follow"] and self.is_on and not self.bits["stop"])

    @property
    def is_moving(self) -> bool:
        """True while a move is under way."""
        return bool(self.axis.get("following"))

    def switch_on(self, *, follows: bool) -> None:
        """Hold the shaft where it is. ``follows``: the set-point's register has that angle then, so that
        nothing jumps."""
        if not self.is_on:
            here_deg = self.here_deg()
            self.set_point_deg = here_deg if follows else self.set_point_deg
            self.axis.set("mode", ord("x"))
            self.axis.set("r", here_deg)
            self.axis.loop(True)
        self.bits["enable"] = 1
        self._following_ns = self._current_ns = 0

    def switch_off(self) -> None:
        """Take the current off."""
        self.axis.loop(False)
        self.axis.vref(0, 0)
        self.bits["enable"] = 0
        self.is_streamed = False

    def step_to(self, set_point_deg: float) -> None:
        """Follow a set-point at once."""
        self.set_point_deg, self.is_streamed = set_point_deg, True
        self.axis.set("r", set_point_deg)
        self._changed_ns = self._now_ns

    def hold(self) -> None:
        """Hold the shaft where it is."""
        self.step_to(self.here_deg())
        self.is_streamed = False

    def follow(self, path: Path, start_ns: int = 0) -> None:
        """Let the set-point follow a path, from a time or from now on."""
        self.axis.follow(path, start_ns)
        self._path, self._path_from_ns = path, max(start_ns, self._now_ns)
        self.set_point_deg, self.is_streamed = path[-1].r, False

    @property
    def target_deg(self) -> float:
        """Angle at which a move that is under way will end, or the set-point."""
        return self._path[-1].r if self.is_moving else self.axis.get("r")

    def tell(self) -> None:
        """Tell the registers' values."""
        told = {
            "set_point_deg": self.set_point_deg,
            "set_velocity_rpm": self.velocity_rpm,
            "acceleration_rpm_per_s": self.acceleration_rpm_per_s,
            "fault_code": self.fault_code,
            "fault": self.fault_code != 0,
            **self.bits,
        }
        for name, value in told.items():
            self._tell(name, value)
        self._tell_motion()

    def _tell_motion(self) -> None:
        self._tell("position_deg", None if self.is_on else self.here_deg())
        has_changed = self.is_streamed and self._now_ns - self._changed_ns < CHANGES_NS
        self._tell("moving", 1.0 if has_changed else None)

    # ---- what it does by itself ----

    def _watch(self) -> None:
        """Look for faults, and tell how it does."""
        if self.is_on and (fault := self._fault()):
            enable = self.bits["enable"]
            self.switch_off()
            self.bits["enable"] = enable  # as it was written: it has to become 1 again
            self.set_point_deg = self.here_deg()
            self.fault_code = fault.code
            self._note("fault", f"fault {fault.code}: {fault.about}")
            self.tell()
        self._tell_motion()

    def _fault(self) -> DriveFault | None:
        if self._encoder_fails():
            return ENCODER
        is_off = abs(self.axis.get("r") - self.axis.get("yw")) > FOLLOWING_DEG
        self._following_ns = self._following_ns + WATCH_NS if is_off else 0
        if self._lacks_current():
            return CURRENT
        return FOLLOWING if self._following_ns >= FOLLOWING_NS else None

    def _where(self) -> tuple[float, float]:
        """Set-point and its rate in degrees a second; of a streamed one the shaft's."""
        if self.is_moving:
            return at(self._path, self._now_ns - self._path_from_ns)
        return self.axis.get("r"), self.axis.get("velocity_rpm") * DEG_PER_S if self.is_streamed else 0.0
