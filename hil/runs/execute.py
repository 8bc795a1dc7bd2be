"""Carries a plan out on a bench, in simulated time: a generator that says until when it has nothing to do."""

from collections.abc import Generator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from math import isnan, sqrt

from hil.runs.axes import Rows, RunBench
from hil.runs.baton import Baton
from hil.runs.document import WaitUntil
from hil.runs.plan import Phrase, Plan
from hil.runs.progress import AxisReport, Ended, How, Progress
from hil.sim.inputs import Do, Follow, Input
from hil.vocab.verbs import VerbRefused

SHOWS_NS = 1_000_000
"""Some steps of a control law, of 154 us each."""
POLL_NS = 10_000_000
"""How often an axis is looked at while it moves."""
SAMPLE_NS = 1_000_000
"""Between two looks at the following error."""
BEGINS_NS = 1_000_000
"""A stepper's motion begins at the first tick of its clock after the command, and says so then."""
STAND_NS = 3_600_000_000_000
"""A stepper that still turns so long after its phrase has failed."""

CHECK_NS = 50_000_000
"""Between two looks whether a servo still does what the run wants of it."""
SETTLE_NS = 200_000_000
"""For a shaft to come to rest after its set-point did."""
SETTLED_DEG = 0.5
TURNS_RPM = 5.0
"""A shaft whose set-point is no angle stands if it is slower: above the noise of a measured speed."""
PULSE_DEG = 0.91
"""A stepper ends at a whole pulse: half a full step of 1.8 deg off at most, and a little."""
ANGLES = (ord("x"), ord("h"))
"""Modes of a servo whose set-point is an angle."""

SERVO_SIGNALS, STEPPER_SIGNALS = ("r", "yw"), ("commanded_deg", "position_deg")


@dataclass
class _Errors:
    rows: Rows
    limit_deg: float | None
    count: int = 0
    squares: float = 0.0


class Execution:
    """One run, or the part of it whose axes are on this bench. ``devices``: those of the bench, by the names
    that the run has for them; ``progress``: where it says how it does."""

    def __init__(
        self,
        plan: Plan,
        bench: RunBench,
        baton: Baton,
        devices: Mapping[str, str] | None = None,
        progress: Progress | None = None,
    ) -> None:
        self.plan = plan
        self._bench = bench
        self._baton = baton
        self._devices = {axis: axis for axis in plan.run.axes} if devices is None else devices
        self._mine = [axis for axis in plan.run.axes if axis in self._devices]
        self._errors: dict[str, _Errors] = {}
        self._refused: dict[str, str] = {}
        """The first verb of an axis that could not be done when its time had come."""
        self._steps_before = 0
        self._asked: Ended | None = None
        self._holds: dict[str, tuple[int, int, float]] = {}
        """Servos that were given a path: from when to when it goes, and its last set-point."""
        self._check_from_ns = 0
        self.stopping: How | None = None
        """How its axes are being stopped."""
        self.ended: Ended | None = None
        """What ended it before its end; its axes may still be stopping."""
        self.reached = -1
        """The phrase whose beginning it waits for, or that has begun; all before have ended here."""
        self.progress = progress or Progress(plan.run.run, steps=plan.steps)

    def stop(self, how: How, why: str | None = None, state: str = "cancelled") -> None:
        """At any time. A run that stops with grace already can be stopped with prejudice."""
        self._asked = Ended(state, why or f"it was cancelled with {how}", how)

    def run(self) -> Generator[int, None, None]:
        """Yields simulated times up to which nothing has to be done; ends when the run has."""
        progress, run = self.progress, self.plan.run
        progress.state, progress.started_at_ns = "running", self._bench.now_ns
        progress.axes = {name: AxisReport(self.plan.ends_deg[name]) for name in self._mine}
        try:
            self._watch()
            if run.start_in_s:
                yield from self._until(self._bench.now_ns + round(run.start_in_s * 1e9))
            for number, phrase in enumerate(self.plan.phrases):
                yield from self._phrase(phrase, (yield from self._start_of(number)))
            yield from self._start_of(len(self.plan.phrases))
            progress.state = "done"
        except Ended as end:
            self.ended = end
            progress.why = str(end)
            yield from self._stop(end.how)
            progress.state = end.state
        except Exception as error:
            progress.state, progress.why = "failed", f"an error of hil, see its log: {error!r}"
            self._give_stop("prejudice")
            raise
        finally:
            self._unwatch()
            progress.ended_at_ns = self._bench.now_ns

    def _start_of(self, number: int) -> Generator[int, None, int]:
        self.reached = number
        while (start_ns := self._baton.start_ns(number)) is None:
            self._look()
            yield self._bench.now_ns + POLL_NS
        return start_ns

    def _phrase(self, phrase: Phrase, start_ns: int) -> Generator[int, None, None]:
        lasts_ns = phrase.duration_ns
        for axis, path in phrase.paths.items():
            if axis in self._mine:
                self._give(axis, Follow(start_ns, path))
                (given_ns,) = self._fields(axis, "at_ns")
                if given_ns > start_ns:  # late: what it does shows with the law's next step
                    begin_ns = round(given_ns)
                    end_ns = max(start_ns + phrase.duration_ns, begin_ns + SHOWS_NS)
                else:
                    begin_ns, end_ns = start_ns, start_ns + phrase.duration_ns
                self._holds[axis] = (begin_ns, end_ns, path[-1].r)
                lasts_ns = max(lasts_ns, end_ns - start_ns)
        for event in phrase.events:
            if event.axis in self._mine:
                at_ns = start_ns + event.at_ns
                self._give(event.axis, Do(event.verb, tuple(event.parameters.items()), at_ns))
        end_ns = start_ns + lasts_ns + (BEGINS_NS if phrase.steppers else 0)
        marks = [(start_ns + at_ns, number) for number, (at_ns, _) in enumerate(phrase.marks, 1)]
        yield from self._until(end_ns, marks)
        self._steps_before += len(phrase.marks)
        give_up_ns = end_ns + STAND_NS
        while self._turning(phrase):
            if self._bench.now_ns > give_up_ns:
                raise Ended("failed", "a stepper does not come to its end", self.plan.run.on_fault)
            yield from self._until(self._bench.now_ns + POLL_NS)
        self._check_ends(phrase)
        if phrase.wait and phrase.wait.axis in self._mine:
            yield from self._wait(phrase.wait)

    def _turning(self, phrase: Phrase) -> bool:
        steppers = phrase.steppers.intersection(self._mine)
        return any(any(self._fields(axis, "motion_state", "pending")) for axis in steppers)

    def _check_ends(self, phrase: Phrase) -> None:
        """Whether the axes are where the phrase leads."""
        for axis in self._holds:
            self._check(axis)
        for event in phrase.events:
            if event.axis in self._mine and event.verb == "move_abs":
                (commanded_deg,) = self._fields(event.axis, "commanded_deg")
                wanted_deg = float(event.parameters["position_deg"])
                if abs(commanded_deg - wanted_deg) > PULSE_DEG:
                    why = f"{event.axis} ended at {commanded_deg:.2f} deg and not at {wanted_deg:.2f}:"
                    raise self._failed(f"{why} something else moved or reset it")

    def _check(self, axis: str) -> None:
        """Whether a servo does what it was told, and nobody told it otherwise."""
        start_ns, end_ns, last_deg = self._holds[axis]
        now_ns, loop_on, mode, following, r = self._fields(axis, "at_ns", "loop_on", "mode", "following", "r")
        if isnan(loop_on):
            return
        if not loop_on:
            raise self._failed(f"{axis}: its control loop is off; somebody disabled it, or reset the board")
        is_over = now_ns > end_ns
        is_other = abs(r - last_deg) > max(0.01, abs(last_deg) * 1e-6) if is_over else not following
        if mode not in ANGLES or (is_other and now_ns > start_ns + POLL_NS):
            raise self._failed(f"{axis}: its mode or its set-point was changed by something else")

    def _failed(self, why: str) -> Ended:
        return Ended("failed", why, self.plan.run.on_fault)

    def _wait(self, wait: WaitUntil) -> Generator[int, None, None]:
        give_up_ns = self._bench.now_ns + round(wait.timeout_s * 1e9)
        while not self._is_met(self._fields(wait.axis, wait.field)[0], wait.above, wait.below):
            if self._bench.now_ns >= give_up_ns:
                why = f"{wait.axis}.{wait.field} was not in its range for {wait.timeout_s:g} s"
                raise self._failed(why)
            yield from self._until(min(self._bench.now_ns + POLL_NS, give_up_ns))

    @staticmethod
    def _is_met(value: float, above: float | None, below: float | None) -> bool:
        return (above is None or value >= above) and (below is None or value <= below)

    def _until(self, end_ns: int, marks: Sequence[tuple[int, int]] = ()) -> Generator[int, None, None]:
        """Until then, looking at the axes meanwhile."""
        while True:
            now_ns = self._bench.now_ns
            begun = [number for at_ns, number in marks if at_ns <= now_ns]
            if begun:
                self.progress.step = self._steps_before + begun[-1]
            self._look()
            if now_ns >= end_ns and self._have_reached(end_ns):
                return
            yield min(now_ns + POLL_NS, end_ns) if now_ns < end_ns else now_ns + POLL_NS

    def _have_reached(self, at_ns: int) -> bool:
        """Whether what is read of the axes is of then, or later: a board that has much to do comes behind."""
        return not any(self._fields(axis, "at_ns")[0] < at_ns for axis in self._mine)

    def _look(self) -> None:
        on_fault = self.plan.run.on_fault
        if self._asked:
            raise self._asked
        for axis, errors in self._errors.items():
            if why := self._failure(axis):
                raise Ended("failed", f"{axis} stopped: {why}", on_fault)
            if axis in self._refused:
                raise Ended("failed", f"{axis}: {self._refused[axis]}", on_fault)
            worst_deg = self._note(axis, errors)
            if errors.limit_deg is not None and worst_deg > errors.limit_deg:
                why = (
                    f"{axis} is {worst_deg:.3g} deg from where it should be, {errors.limit_deg:g} are allowed"
                )
                raise Ended("failed", why, on_fault)
        if (now_ns := self._bench.now_ns) >= self._check_from_ns:
            self._check_from_ns = now_ns + CHECK_NS
            for axis in self._holds:
                self._check(axis)

    def _note(self, axis: str, errors: _Errors) -> float:
        """Take new samples in; the greatest error among them."""
        rows = errors.rows.take()
        found = [abs(wanted - is_at) for _, wanted, is_at in rows]
        report = self.progress.axes[axis]
        if found:
            report.position_deg = rows[-1][2]
            errors.count += len(found)
            errors.squares += sum(error * error for error in found)
            report.error_max_deg = max(report.error_max_deg or 0.0, *found)
            report.error_rms_deg = sqrt(errors.squares / errors.count)
        return max(found, default=0.0)

    def _give(self, axis: str, given: Input) -> None:
        try:
            self._bench.give(self._devices[axis], given, partial(self._note_refusal, axis))
        except VerbRefused as refusal:
            raise self._failed(f"{axis}: {refusal}") from None

    def _note_refusal(self, axis: str, why: str) -> None:
        self._refused.setdefault(axis, why)

    def _fields(self, axis: str, *names: str) -> Sequence[float]:
        return self._bench.fields(self._devices[axis], names)

    def _failure(self, axis: str) -> str | None:
        return self._bench.failure(self._devices[axis])

    def _stop(self, how: How) -> Generator[int, None, None]:
        """All axes of the run, whatever they do; and until they stand."""
        self.stopping = how
        self._give_stop(how)
        give_up_ns = self._bench.now_ns + STAND_NS
        while any(self._moves(axis) for axis in self._errors) and self._bench.now_ns < give_up_ns:
            if self.stopping == "grace" and self._asked and self._asked.how == "prejudice":
                self.stopping = "prejudice"
                self._give_stop("prejudice")
            yield self._bench.now_ns + POLL_NS
            for axis, errors in self._errors.items():
                self._note(axis, errors)
        settled_ns = self._bench.now_ns + SETTLE_NS
        while not all(map(self._is_settled, self._errors)) and self._bench.now_ns < settled_ns:
            yield self._bench.now_ns + POLL_NS

    def _give_stop(self, how: How) -> None:
        for axis in self._errors:
            parameters: list[tuple[str, float | str]] = [("how", how)]
            if not self._is_stepper(axis):
                rules = self.plan.run.axes[axis]
                parameters.append(("acceleration_rpm_per_s", max(rules.acceleration_rpm_per_s, 0.01)))
            with suppress(Ended):  # it has failed, or its loop is off: it does not move by itself
                self._give(axis, Do("stop", tuple(parameters)))

    def _moves(self, axis: str) -> bool:
        if self._failure(axis):
            return False
        if self._is_stepper(axis):
            return any(self._fields(axis, "motion_state"))
        loop_on, following, mode, rpm = self._fields(axis, "loop_on", "following", "mode", "velocity_rpm")
        return bool(following) or (bool(loop_on) and mode not in ANGLES and abs(rpm) > TURNS_RPM)

    def _is_settled(self, axis: str) -> bool:
        if self._is_stepper(axis) or self._failure(axis):
            return True
        loop_on, mode, r, yw = self._fields(axis, "loop_on", "mode", "r", "yw")
        return not (loop_on and mode in ANGLES and abs(r - yw) > SETTLED_DEG)

    def _is_stepper(self, axis: str) -> bool:
        return self.plan.axes[axis].kind == "stepper"

    def _watch(self) -> None:
        for axis in self._mine:
            rules = self.plan.run.axes[axis]
            signals = STEPPER_SIGNALS if self._is_stepper(axis) else SERVO_SIGNALS
            rows = self._bench.sample(self._devices[axis], signals, SAMPLE_NS)
            self._errors[axis] = _Errors(rows, rules.following_error_deg)

    def _unwatch(self) -> None:
        for axis, errors in self._errors.items():
            self._note(axis, errors)
            errors.rows.close()
            report = self.progress.axes[axis]
            names = ("position_deg", "commanded_deg") if self._is_stepper(axis) else ("yw", "r")
            told = [None if isnan(value) else value for value in self._fields(axis, *names)]
            report.position_deg, report.commanded_deg = told
            report.at_end = self._at_end(axis)

    def _at_end(self, axis: str) -> str:
        if self._failure(axis):
            return "failed"
        if not self._is_stepper(axis) and not self._fields(axis, "loop_on")[0]:
            return "off"
        return "moves" if self._moves(axis) else "stands"
