"""Axis while a run has it: its inputs, the check that it follows them, and its error."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import isnan, sqrt

from hil.runs.axes import AxisNow, RunBench
from hil.runs.progress import AxisReport, Ended, How
from hil.runs.run_document import AxisRules
from hil.sim.inputs import Do, Follow, Input
from hil.vocab.path import PathPiece
from hil.vocab.verbs import VerbRefused

SHOWS_NS = 1_000_000
"""Time until a motion shows: some steps of a control law, of 154 us each."""
SAMPLE_NS = 1_000_000
"""Interval of looks at the following error."""
LATE_NS = 10_000_000
"""Time from the beginning of a path until it must show."""
SETTLED_DEG = 0.5
TURNS_RPM = 5.0
"""Speed below which a shaft whose set-point is no angle stands: above the noise of a measured speed."""
PULSE_DEG = 0.91
"""Maximum error at a stepper's end, which is at a whole pulse: half a full step of 1.8 deg, and a little."""
ANGLES = (ord("x"), ord("h"))
"""Modes of a servo whose set-point is an angle."""

SERVO_SIGNALS, STEPPER_SIGNALS = ("r", "yw"), ("commanded_deg", "position_deg")


@dataclass(eq=False)
class RunAxis:
    """Axis of a run. ``name`` is the run's for it, ``device`` the bench's; ``on_fault``: how all axes stop
    when this one fails. It is watched from now until ``close``."""

    name: str
    device: str
    bench: RunBench
    before: AxisNow
    rules: AxisRules
    report: AxisReport
    on_fault: How

    def __post_init__(self) -> None:
        self.is_stepper = self.before.kind == "stepper"
        self._refused: list[str] = []
        """Refusals of verbs that could not be done when their time had come."""
        self._path: tuple[int, int, float] | None = None
        """Path of a servo: its beginning and end, and its last set-point."""
        self._count, self._squares = 0, 0.0
        signals = STEPPER_SIGNALS if self.is_stepper else SERVO_SIGNALS
        self._rows = self.bench.sample(self.device, signals, SAMPLE_NS)

    def fields(self, *names: str) -> Sequence[float]:
        """Values of fields, all of one time. NaN: unknown."""
        return self.bench.fields(self.device, names)

    # ---- what it is given ----

    def give(self, given: Input) -> None:
        """Let an input take effect. Raises Ended: it was refused."""
        try:
            self.bench.give(self.device, given, self._refused.append)
        except VerbRefused as refusal:
            raise self.failed(f"{self.name}: {refusal}") from None

    def follow(self, path: Sequence[PathPiece], start_ns: int, duration_ns: int) -> int:
        """Let a servo's set-point go along a path; answers its end."""
        self.give(Follow(start_ns, tuple(path)))
        (given_ns,) = self.fields("at_ns")
        begin_ns, end_ns = start_ns, start_ns + duration_ns
        if given_ns > start_ns:  # late: what it does shows with the law's next step
            begin_ns = round(given_ns)
            end_ns = max(end_ns, begin_ns + SHOWS_NS)
        self._path = begin_ns, end_ns, path[-1].r
        return end_ns

    def stop(self, how: How) -> None:
        """Stop it, whatever it does."""
        parameters: list[tuple[str, float | str]] = [("how", how)]
        if not self.is_stepper:
            parameters.append(("acceleration_rpm_per_s", max(self.rules.acceleration_rpm_per_s, 0.01)))
        with suppress(Ended):  # it has failed, or its loop is off: it does not move by itself
            self.give(Do("stop", tuple(parameters)))

    # ---- whether it does that ----

    def look(self) -> None:
        """Take its samples in. Raises Ended: it has stopped, refused a verb, or is too far off."""
        if why := self.bench.failure(self.device):
            raise self.failed(f"{self.name} stopped: {why}")
        if self._refused:
            raise self.failed(f"{self.name}: {self._refused[0]}")
        worst_deg, limit_deg = self.note(), self.rules.following_error_deg
        if limit_deg is not None and worst_deg > limit_deg:
            why = f"{self.name} is {worst_deg:.3g} deg from where it should be, {limit_deg:g} are allowed"
            raise self.failed(why)

    def note(self) -> float:
        """Take its new samples in; answers the greatest error among them."""
        rows = self._rows.take()
        found = [abs(wanted - is_at) for _, wanted, is_at in rows]
        if found:
            report = self.report
            report.position_deg = rows[-1][2]
            self._count += len(found)
            self._squares += sum(error * error for error in found)
            report.error_max_deg = max(report.error_max_deg or 0.0, *found)
            report.error_rms_deg = sqrt(self._squares / self._count)
        return max(found, default=0.0)

    def check_path(self) -> None:
        """Check the path. Raises Ended: it does not follow, or somebody told it otherwise."""
        if self._path is None:
            return
        start_ns, end_ns, last_deg = self._path
        now_ns, loop_on, mode, following, r = self.fields("at_ns", "loop_on", "mode", "following", "r")
        if isnan(loop_on):
            return
        if not loop_on:
            raise self.failed(
                f"{self.name}: its control loop is off; somebody disabled it, or reset the board"
            )
        is_over = now_ns > end_ns
        is_other = abs(r - last_deg) > max(0.01, abs(last_deg) * 1e-6) if is_over else not following
        if mode not in ANGLES or (is_other and now_ns > start_ns + LATE_NS):
            raise self.failed(f"{self.name}: its mode or its set-point was changed by something else")

    def check_end(self, wanted_deg: float) -> None:
        """Check a stepper's end. Raises Ended: it is not where it was sent."""
        (commanded_deg,) = self.fields("commanded_deg")
        if abs(commanded_deg - wanted_deg) > PULSE_DEG:
            why = f"{self.name} ended at {commanded_deg:.2f} deg and not at {wanted_deg:.2f}:"
            raise self.failed(f"{why} something else moved or reset it")

    def failed(self, why: str) -> Ended:
        return Ended("failed", why, self.on_fault)

    @property
    def turns(self) -> bool:
        """Whether a stepper moves, or is to; or a real servo has not confirmed its last set-point."""
        return any(self.fields("motion_state", "pending"))

    @property
    def moves(self) -> bool:
        if self.bench.failure(self.device):
            return False
        if self.is_stepper:
            return any(self.fields("motion_state"))
        loop_on, following, mode, rpm = self.fields("loop_on", "following", "mode", "velocity_rpm")
        return bool(following) or (bool(loop_on) and mode not in ANGLES and abs(rpm) > TURNS_RPM)

    @property
    def is_settled(self) -> bool:
        if self.is_stepper or self.bench.failure(self.device):
            return True
        loop_on, mode, r, yw = self.fields("loop_on", "mode", "r", "yw")
        return not (loop_on and mode in ANGLES and abs(r - yw) > SETTLED_DEG)

    # ---- its end ----

    def close(self) -> None:
        """Release it: the run has it no more; its report is complete."""
        self.note()
        self._rows.close()
        names = ("position_deg", "commanded_deg") if self.is_stepper else ("yw", "r")
        told = [None if isnan(value) else value for value in self.fields(*names)]
        self.report.position_deg, self.report.commanded_deg = told
        self.report.at_end = self._at_end()

    def _at_end(self) -> str:
        if self.bench.failure(self.device):
            return "failed"
        if not self.is_stepper and not self.fields("loop_on")[0]:
            return "off"
        return "moves" if self.moves else "stands"
