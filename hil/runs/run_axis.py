"""Axis while a run has it: the bounds of its board, what it is given, the check that it does that."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from math import sqrt

from hil.config.document import Finding
from hil.runs.plan import Level, Move
from hil.runs.progress import AxisReport, Ended
from hil.runs.run_document import AxisRules, RunDocument
from hil.vocab.axis import Axis, AxisNow, AxisState, How
from hil.vocab.parameters import Parameter, plain
from hil.vocab.path import Path
from hil.vocab.seen_over import seen_over
from hil.vocab.verbs import Verb, VerbRefused

LIMITS = {"velocity_rpm": "rpm", "acceleration_rpm_per_s": "rpm/s"}
"""Limits of a run's axes that boards have bounds for, with their units."""
WHOLE_RPM = Parameter("velocity_rpm", "", minimum=1, is_whole=True)
"""Speeds of a board that says nothing of them."""
_ASKED = ("position_deg", *LIMITS)


def bounds_of(verbs: Mapping[str, Verb], *, follows_paths: bool) -> dict[str, Parameter]:
    """Find the bounds of a board with these verbs: of its stop, and of the verb that sends it to an angle if
    it follows no paths."""
    used = [verbs[name] for name in (("stop",) if follows_paths else ("stop", "move_abs")) if name in verbs]
    return {each.name: each for verb in used for each in verb.parameters if each.name in _ASKED}


def fitted(run: RunDocument, axes: Mapping[str, AxisNow]) -> RunDocument:
    """Let the limits that nobody chose be such that the boards take them."""

    def of_axis(name: str, rules: AxisRules) -> AxisRules:
        bounds = axes[name].bounds
        chosen = {
            key: bound.maximum if bound.default is None else float(bound.default)
            for key, bound in bounds.items()
            if key in LIMITS.keys() - rules.model_fields_set and not _is_within(getattr(rules, key), bound)
        }
        return rules.model_copy(update=chosen) if chosen else rules

    return run.model_copy(update={"axes": {name: of_axis(name, rules) for name, rules in run.axes.items()}})


def bound_findings(run: RunDocument, axes: Mapping[str, AxisNow]) -> Iterator[Finding]:
    """Find the limits that boards do not take."""
    for name, rules in run.axes.items():
        for key, unit in LIMITS.items():
            bound = axes[name].bounds.get(key)
            if bound and not _is_within(getattr(rules, key), bound):
                least, most = plain(bound.minimum), plain(bound.maximum)
                what = f"{name} takes {least} to {most} {unit}"
                yield Finding(("axes", name, key), what, f"write {least} to {most}, or leave it out")


def _is_within(value: float, bound: Parameter) -> bool:
    return bound.minimum <= value <= bound.maximum


LAST_NS = 1_000_000_000
"""Time beyond the planned end of a path for which an axis may still be on it."""
LATE_NS = 10_000_000
"""Time from the beginning of a path until it must show."""
SETTLED_DEG = 0.5
PULSE_DEG = 0.91
"""Maximum error at the end of a motion in whole pulses: half a full step of 1.8 deg, and a little."""


@dataclass(eq=False)
class RunAxis:
    """Axis of a run. ``name`` is the run's for it; ``on_fault``: how all axes stop when this one fails. It is
    held from now until ``close``."""

    name: str
    axis: Axis
    rules: AxisRules
    report: AxisReport
    on_fault: How

    def __post_init__(self) -> None:
        self._path: tuple[int, int, float] | None = None
        """Path that the axis follows: its beginning and end, and its last set-point."""
        self._count, self._squares = 0, 0.0
        self.axis.hold()

    def state(self) -> AxisState:
        return self.axis.state()

    # ---- what it is given ----

    def give(self, event: Move | Level, start_ns: int) -> None:
        """Give the axis an event of a phrase that starts then. Raises Ended: it was refused."""
        try:
            event.give(self.axis, start_ns)
        except VerbRefused as refusal:
            raise self.failed(f"{self.name}: {refusal}") from None

    def follow(self, path: Path, start_ns: int, duration_ns: int, last_deg: float) -> int:
        """Let the axis's set-point go along a path, of which this is the beginning or all; answers the time
        at which it begins, later than the start if it comes late. Raises Ended: it was refused."""
        try:
            begin_ns = self.axis.follow(path, start_ns)
        except VerbRefused as refusal:
            raise self.failed(f"{self.name}: {refusal}") from None
        self._path = begin_ns, begin_ns + duration_ns, last_deg
        return begin_ns

    @property
    def begins_ns(self) -> int:
        """Beginning of the path that it follows. It follows one."""
        assert self._path is not None
        return self._path[0]

    def join(self, path: Path, start_ns: int, end_ns: int, last_deg: float) -> None:
        """Let the axis's set-point go on along a path that began then; the whole way ends at ``end_ns`` at
        ``last_deg``. Raises Ended: it was refused."""
        try:
            self.axis.join(path, start_ns)
        except VerbRefused as refusal:
            raise self.failed(f"{self.name}: {refusal}") from None
        self._path = self.state().at_ns, end_ns, last_deg

    def stop(self, how: How) -> None:
        """Stop the axis, whatever it does."""
        with suppress(VerbRefused):  # the axis has failed, or its loop is off: it does not move by itself
            self.axis.stop(how, self.rules.acceleration_rpm_per_s)

    # ---- whether it does that ----

    def look(self) -> None:
        """Take the axis's samples in. Raises Ended: it has stopped, refused a verb, or is too far off."""
        if why := self.axis.failure:
            raise self.failed(f"{self.name} stopped: {why}")
        if why := self.axis.refusal:
            raise self.failed(f"{self.name}: {why}")
        worst_deg, limit_deg = self.note(), self.rules.following_error_deg
        if limit_deg is not None and worst_deg > limit_deg:
            shown = seen_over(worst_deg, limit_deg)
            why = f"{self.name} is {shown} deg from where it should be, {limit_deg:g} are allowed"
            raise self.failed(why)

    def note(self) -> float:
        """Take the axis's new samples in; answers the greatest error among them."""
        rows = self.axis.samples()
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
        """Check the path. Raises Ended: the axis does not follow it, or got another command."""
        if self._path is None or (state := self.state()).is_on is None or state.commanded_deg is None:
            return
        start_ns, end_ns, last_deg = self._path
        if not state.is_on:
            raise self.failed(
                f"{self.name}: its control loop is off; somebody disabled it, or reset the board"
            )
        off_deg, is_over = abs(state.commanded_deg - last_deg), state.at_ns > end_ns
        is_off = off_deg > max(0.01, abs(last_deg) * 1e-6) and not self.is_on_the_last_of_its_path(state)
        is_other = is_off if is_over else not state.is_under_way
        if not state.keeps_angle or (is_other and state.at_ns > start_ns + LATE_NS):
            raise self.failed(f"{self.name}: its mode or its set-point was changed by something else")

    def is_on_the_last_of_its_path(self, state: AxisState) -> bool:
        """True while an axis goes on along its path beyond the planned end, as on a computer that is late."""
        return (
            self._path is not None
            and state.is_under_way
            and self._path[1] < state.at_ns <= self._path[1] + LAST_NS
        )

    def check_end(self, wanted_deg: float) -> None:
        """Check where a motion by its own ramps ended. Raises Ended: it is not where it was sent."""
        commanded_deg = self.state().commanded_deg
        if commanded_deg is not None and abs(commanded_deg - wanted_deg) > PULSE_DEG:
            why = f"{self.name} ended at {commanded_deg:.2f} deg and not at {wanted_deg:.2f}:"
            raise self.failed(f"{why} something else moved or reset it")

    def failed(self, why: str) -> Ended:
        return Ended("failed", why, self.on_fault)

    @property
    def is_under_way(self) -> bool:
        """True while the axis has a motion that has not ended."""
        return self.state().is_under_way

    @property
    def moves(self) -> bool:
        return not self.axis.failure and self.state().is_moving

    @property
    def is_settled(self) -> bool:
        return bool(self.axis.failure) or self.state().off_by_deg <= SETTLED_DEG

    # ---- its end ----

    def close(self) -> None:
        """Release the axis: the run has it no more; its report is complete."""
        self.note()
        self.axis.release()
        state = self.state()
        self.report.position_deg, self.report.commanded_deg = state.position_deg, state.commanded_deg
        self.report.at_end = self._at_end(state)

    def _at_end(self, state: AxisState) -> str:
        if self.axis.failure:
            return "failed"
        if state.is_on is False:
            return "off"
        return "moves" if state.is_moving else "stands"
