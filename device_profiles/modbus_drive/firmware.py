"""Program of the drive: its loop, its ramps, and what makes it give up."""

from device_profiles.modbus_drive.home_search import HomeSearch, is_at_limit
from hil.firmware.closed_loop_drive import CURRENT, ENCODER, IDLE_NS, WATCH_NS, ClosedLoopDrive, DriveFault
from hil.firmware.homing_methods import METHODS
from hil.firmware.kept_cells import KeptCells
from hil.firmware.set_point_paths import at, joined, length_ns, trapezoid
from hil.vocab.drive_words import USUAL_HOMING
from hil.vocab.firmware import Board, Delay, Main
from hil.vocab.path import DEG_PER_S, Path, PathPiece
from hil.vocab.time import NS_PER_MS, NS_PER_S

FOLLOWING_DEG, FOLLOWING_NS = 30.0, 50 * NS_PER_MS
"""Following error that is too large, once it has lasted so long."""
CHANGES_NS = 50 * NS_PER_MS
"""Time after a followed set-point for which the drive says that it moves."""
VELOCITY_RPM, ACCELERATION_RPM_PER_S = 60.0, 600.0
"""Speed and acceleration of moves, from power-up until others are written."""
BITS = ("enable", "start", "stop", "reset", "follow")
TURNS_FOR_NS, TURNS_AGAIN_NS = 600 * NS_PER_S, 60 * NS_PER_S
"""Length of a path at a constant speed, and what is left of it when the next one begins."""
FOLLOWING = DriveFault(1, f"{FOLLOWING_DEG:g} deg off the set-point for {FOLLOWING_NS // NS_PER_MS} ms")


class ModbusDrive(ClosedLoopDrive):
    """One power-up of the drive.

    Long because moves, followed set-points and turning share one path and its end.
    """

    def __init__(self, board: Board) -> None:
        super().__init__(board, FOLLOWING)
        self._servo = board.servo
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
        self.homing_method = USUAL_HOMING
        self.homing_velocity_rpm: float | None = None
        self.homing_slow_rpm: float | None = None
        """Speeds of the search for home; None: never written."""
        self._search: HomeSearch | None = None
        self._has_home = self._has_missed = False
        self._limit_deg: float | None = None
        """Angle at which it comes to rest because of a limit switch; None: it does not."""
        self.deceleration_rpm_per_s: float | None = None
        """None: never written; ramps down as up."""
        self.run_velocity_rpm: float | None = None
        """Speed to turn at; None: never written, that of moves."""
        self.is_reversed = False
        self.origin_deg = 0.0
        """Angle of the shaft that a master sees as 0."""
        self.running_rpm: float | None = None
        """Speed at which it turns until a stop; None: it does not."""
        self._runs_by_registers = False
        """True if it turns at the speed that its registers have, and changes with them."""
        self._turns_until_ns = 0
        """Time at which its path ends while it turns, of whatever length its ramps are."""
        self.cells = KeptCells(board.nvm, board.tell)

    def main(self) -> Main:
        self._servo.do("own_step", 1)  # D1 is the switch's, and no input for steps
        yield from self._start()
        self.set_point_deg = self.here_deg()
        self.is_busy = False
        self.cells.tell_all()
        self.tell()
        while True:
            self._watch()
            if commit := self.cells.step(self._now_ns):
                yield commit
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
        self.running_rpm = None

    def step_to(self, set_point_deg: float) -> None:
        """Follow a set-point at once."""
        self.set_point_deg, self.is_streamed = set_point_deg, True
        self.running_rpm = None
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
        self.running_rpm = None

    def go(
        self, target_deg: float, velocity_rpm: float, up_rpm_per_s: float, down_rpm_per_s: float | None
    ) -> Path:
        """Go to an angle with another deceleration than acceleration. Raises VerbRefused."""
        kept_deg = self.set_point_deg
        up, down = up_rpm_per_s * DEG_PER_S, (down_rpm_per_s or up_rpm_per_s) * DEG_PER_S
        path = self._along(lambda: trapezoid(*self._where(), target_deg, velocity_rpm * DEG_PER_S, up, down))
        self.set_point_deg = kept_deg  # the register is the master's
        return path

    def run(
        self,
        velocity_rpm: float | None = None,
        up_rpm_per_s: float | None = None,
        down_rpm_per_s: float | None = None,
    ) -> None:
        """Turn at a speed until a stop. ``velocity_rpm``: None: that of the registers, also when they change.
        Raises VerbRefused."""
        self._runs_by_registers = velocity_rpm is None
        if velocity_rpm is None:
            velocity_rpm = self.velocity_rpm if self.run_velocity_rpm is None else self.run_velocity_rpm
        wanted = (-velocity_rpm if self.is_reversed else velocity_rpm) * DEG_PER_S
        up = (up_rpm_per_s or self.acceleration_rpm_per_s) * DEG_PER_S
        down = (down_rpm_per_s or self.deceleration_rpm_per_s or up / DEG_PER_S) * DEG_PER_S
        kept_deg = self.set_point_deg
        path = self._along(lambda: _to_speed(*self._where(), wanted, up, down))
        self._turns_until_ns = self._path_from_ns + length_ns(path)
        self.set_point_deg, self.running_rpm = kept_deg, wanted / DEG_PER_S

    def run_again(self) -> None:
        """Turn as the registers say now, if it turns by them."""
        if self.running_rpm is not None and self._runs_by_registers:
            self.run()

    @property
    def now_ns(self) -> int:
        """Simulated time."""
        return self._now_ns

    @property
    def is_running(self) -> bool:
        """True while it turns until a stop."""
        return self.running_rpm is not None and self.is_on

    def zero(self) -> None:
        """Let a master see the present angle of the shaft as 0."""
        self.origin_deg = self.here_deg()

    def search_home(self, method: int, fast_rpm: float, slow_rpm: float) -> None:
        """Search home by a homing method, which there is. Raises VerbRefused."""
        self._has_home = self._has_missed = False
        self._search = HomeSearch(self, METHODS[method], fast_rpm, slow_rpm)

    @property
    def target_deg(self) -> float:
        """Angle at which a move that is under way will end, or the set-point; of what turns, that of now."""
        if self.is_running:
            return self._where()[0]
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
        rare = {
            "deceleration_rpm_per_s": self.deceleration_rpm_per_s,
            "run_velocity_rpm": self.run_velocity_rpm,
            "origin_deg": self.origin_deg or None,
            "reverse": float(self.is_reversed) or None,
            "running": float(self.is_running) or None,
            "running_rpm": self.running_rpm,
            "homing": float(self._search is not None) or None,
            "homed": float(self._has_home) or None,
            "home_missed": float(self._has_missed) or None,
            "homing_method": None if self.homing_method == USUAL_HOMING else float(self.homing_method),
            "homing_velocity_rpm": self.homing_velocity_rpm,
            "homing_slow_rpm": self.homing_slow_rpm,
        }
        for name, rare_value in rare.items():
            self._tell(name, rare_value)
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
            self.running_rpm = None
            self._note("fault", f"fault {fault.code}: {fault.about}")
            self.tell()
        if self._search:
            self._search_on(self._search)
        elif self.is_on:
            self._keep_off_limits()
        if self.is_running and self._turns_until_ns - self._now_ns < TURNS_AGAIN_NS:
            running_rpm, is_reversed = self.running_rpm or 0.0, self.is_reversed
            by_registers, self.is_reversed = self._runs_by_registers, False
            self.run(running_rpm)
            self._runs_by_registers, self.is_reversed = by_registers, is_reversed
        self._tell_motion()

    def _search_on(self, search: HomeSearch) -> None:
        if self.is_on:
            search.step()
        if search.is_over or not self.is_on:
            self._search, self._has_home = None, search.home_deg is not None
            self._has_missed = not self._has_home
            self.origin_deg = self.origin_deg if search.home_deg is None else search.home_deg
            self.tell()

    def _keep_off_limits(self) -> None:
        """Stop a motion by the ramp that goes on beyond a limit switch."""
        if not self.is_moving:
            self._limit_deg = None
        elif self._limit_deg != self.target_deg and is_at_limit(self.axis, self._where()[1]):
            ramp_rpm_per_s = self.deceleration_rpm_per_s or self.acceleration_rpm_per_s
            self._limit_deg = self.ramp_down(ramp_rpm_per_s)[-1].r
            self.tell()

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


def _to_speed(r: float, rate: float, wanted: float, up: float, down: float) -> Path:
    """Path from a set-point that changes at ``rate`` to a constant rate: down first where it turns round or
    is too fast, up where it is too slow."""
    pieces: list[tuple[float, float]] = []
    if rate * wanted < 0 or (wanted == 0 and rate):
        pieces.append((abs(rate) / down, -down if rate > 0 else down))
        rate_then = 0.0
    else:
        rate_then = rate
    change = wanted - rate_then
    if change:
        ramp = up if abs(wanted) > abs(rate_then) else down
        pieces.append((abs(change) / ramp, ramp if change > 0 else -ramp))
    *ramps, end = joined(r, rate, pieces)
    if not wanted:
        return (*ramps, end)
    long = PathPiece(TURNS_FOR_NS, end.r, wanted)
    return (*ramps, long, PathPiece(0, long.after(TURNS_FOR_NS)[0]))
