"""Carries a plan out on a bench, in simulated time: a generator that says until when it has nothing to do."""

from collections.abc import Generator, Sequence
from dataclasses import asdict, dataclass, field
from math import isnan, sqrt
from typing import Any, Literal, Protocol

from hil.runs.plan import Phrase, Plan
from hil.session.inputs import Do, Follow, Input
from hil.vocab.verbs import VerbRefused

POLL_NS = 10_000_000
"""How often an axis is looked at while it moves."""
SAMPLE_NS = 1_000_000
"""Between two looks at the following error."""
BEGINS_NS = 1_000_000
"""A stepper's motion begins at the first tick of its clock after the command, and says so then."""
STAND_NS = 3_600_000_000_000
"""A stepper that still turns so long after its phrase has failed."""

How = Literal["grace", "prejudice"]
SERVO_SIGNALS, STEPPER_SIGNALS = ("r", "yw"), ("commanded_deg", "position_deg")


class Rows(Protocol):
    """Samples of two fields of an axis."""

    def take(self) -> Sequence[tuple[float, ...]]:
        """Rows of (at_ns, where it should be, where it is) since the last call."""

    def close(self) -> None: ...


class RunBench(Protocol):
    """What an execution needs of a bench. Axes by name."""

    @property
    def now_ns(self) -> int: ...

    def give(self, axis: str, given: Input) -> None:
        """An input takes effect. Raises VerbRefused: a verb was not carried out."""

    def field(self, axis: str, name: str) -> float:
        """NaN: it is not known."""

    def failure(self, axis: str) -> str | None:
        """Why the board does nothing any more."""

    def refusals(self, axis: str) -> Sequence[str]:
        """Of verbs that were to be carried out later, since the last call."""

    def sample(self, axis: str, signals: tuple[str, str], interval_ns: int) -> Rows: ...


@dataclass
class AxisReport:
    """How an axis did. The errors are between where it should have been and was, over the whole run. None: a
    real board's terminal does not tell. ``commanded_deg``: where its set-point is at the end, as the board
    confirmed it; None: it was stopped on its way, and nobody knows."""

    target_deg: float
    commanded_deg: float | None = None
    position_deg: float | None = None
    error_max_deg: float | None = None
    error_rms_deg: float | None = None


@dataclass
class Progress:
    """Of a run. ``state``: queued, running, done, failed or cancelled; ``step`` counts from 1, repetitions
    too. Times are simulated; ``why`` says what ended it."""

    run: str
    state: str = "queued"
    step: int = 0
    steps: int = 0
    started_at_ns: int | None = None
    ended_at_ns: int | None = None
    why: str | None = None
    axes: dict[str, AxisReport] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


class _Ended(Exception):
    def __init__(self, state: str, why: str, how: How) -> None:
        super().__init__(why)
        self.state = state
        self.how = how


@dataclass
class _Errors:
    rows: Rows
    limit_deg: float | None
    count: int = 0
    squares: float = 0.0


class Execution:
    """One run. ``cancel`` may be set at any time."""

    def __init__(self, plan: Plan, bench: RunBench, lead_ns: int) -> None:
        self._plan = plan
        self._bench = bench
        self._lead_ns = lead_ns
        self._errors: dict[str, _Errors] = {}
        self._steps_before = 0
        self.cancel: How | None = None
        self.progress = Progress(plan.run.run, steps=plan.steps)

    def run(self) -> Generator[int, None, None]:
        """Yields simulated times up to which nothing has to be done; ends when the run has."""
        progress, run = self.progress, self._plan.run
        progress.state, progress.started_at_ns = "running", self._bench.now_ns
        progress.axes = {name: AxisReport(target) for name, target in self._plan.ends_deg.items()}
        try:
            self._watch()
            if run.start_in_s:
                yield from self._until(self._bench.now_ns + round(run.start_in_s * 1e9))
            for phrase in self._plan.phrases:
                yield from self._phrase(phrase)
            progress.state = "done"
        except _Ended as end:
            progress.why = str(end)
            yield from self._stop(end.how)
            progress.state = end.state
        finally:
            self._unwatch()
            progress.ended_at_ns = self._bench.now_ns

    def _phrase(self, phrase: Phrase) -> Generator[int, None, None]:
        start_ns = self._bench.now_ns + self._lead_ns
        for axis, path in phrase.paths.items():
            self._give(axis, Follow(start_ns, path))
        for event in phrase.events:
            at_ns = start_ns + event.at_ns
            self._give(event.axis, Do(event.verb, tuple(event.parameters.items()), at_ns))
        end_ns = start_ns + phrase.duration_ns + (BEGINS_NS if phrase.steppers else 0)
        marks = [(start_ns + at_ns, number) for number, (at_ns, _) in enumerate(phrase.marks, 1)]
        yield from self._until(end_ns, marks)
        self._steps_before += len(phrase.marks)
        give_up_ns = end_ns + STAND_NS
        while self._turning(phrase):
            if self._bench.now_ns > give_up_ns:
                raise _Ended("failed", "a stepper does not come to its end", self._plan.run.on_fault)
            yield from self._until(self._bench.now_ns + POLL_NS)
        if phrase.wait:
            yield from self._wait(phrase)

    def _turning(self, phrase: Phrase) -> bool:
        return any(
            self._bench.field(axis, "motion_state") or self._bench.field(axis, "pending")
            for axis in phrase.steppers
        )

    def _wait(self, phrase: Phrase) -> Generator[int, None, None]:
        wait = phrase.wait
        assert wait is not None
        give_up_ns = self._bench.now_ns + round(wait.timeout_s * 1e9)
        while not self._is_met(self._bench.field(wait.axis, wait.field), wait.above, wait.below):
            if self._bench.now_ns >= give_up_ns:
                why = f"{wait.axis}.{wait.field} was not in its range for {wait.timeout_s:g} s"
                raise _Ended("failed", why, self._plan.run.on_fault)
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
            if now_ns >= end_ns:
                return
            yield min(now_ns + POLL_NS, end_ns)

    def _look(self) -> None:
        on_fault = self._plan.run.on_fault
        if self.cancel:
            raise _Ended("cancelled", f"it was cancelled with {self.cancel}", self.cancel)
        for axis, errors in self._errors.items():
            if why := self._bench.failure(axis):
                raise _Ended("failed", f"{axis} stopped: {why}", on_fault)
            if refusals := self._bench.refusals(axis):
                raise _Ended("failed", f"{axis}: {refusals[0]}", on_fault)
            worst_deg = self._note(axis, errors)
            if errors.limit_deg is not None and worst_deg > errors.limit_deg:
                why = (
                    f"{axis} is {worst_deg:.3g} deg from where it should be, {errors.limit_deg:g} are allowed"
                )
                raise _Ended("failed", why, on_fault)

    def _note(self, axis: str, errors: _Errors) -> float:
        """Take new samples in; the greatest error among them."""
        found = [abs(wanted - is_at) for _, wanted, is_at in errors.rows.take()]
        report = self.progress.axes[axis]
        if found:
            errors.count += len(found)
            errors.squares += sum(error * error for error in found)
            report.error_max_deg = max(report.error_max_deg or 0.0, *found)
            report.error_rms_deg = sqrt(errors.squares / errors.count)
        return max(found, default=0.0)

    def _give(self, axis: str, given: Input) -> None:
        try:
            self._bench.give(axis, given)
        except VerbRefused as refusal:
            raise _Ended("failed", f"{axis}: {refusal}", self._plan.run.on_fault) from None

    def _stop(self, how: How) -> Generator[int, None, None]:
        """All axes of the run, whatever they do; and until they stand."""
        for axis in self._errors:
            parameters: list[tuple[str, float | str]] = [("how", how)]
            if not self._is_stepper(axis):
                rules = self._plan.run.axes[axis]
                parameters.append(("acceleration_rpm_per_s", max(rules.acceleration_rpm_per_s, 0.01)))
            try:
                self._bench.give(axis, Do("stop", tuple(parameters)))
            except VerbRefused:
                continue  # it has failed, or its loop is off: it does not move by itself
        give_up_ns = self._bench.now_ns + STAND_NS
        while any(self._moves(axis) for axis in self._errors) and self._bench.now_ns < give_up_ns:
            yield self._bench.now_ns + POLL_NS
            for axis, errors in self._errors.items():
                self._note(axis, errors)

    def _moves(self, axis: str) -> bool:
        if self._bench.failure(axis):
            return False
        return bool(self._bench.field(axis, "motion_state" if self._is_stepper(axis) else "following"))

    def _is_stepper(self, axis: str) -> bool:
        return self._plan.axes[axis].kind == "stepper"

    def _watch(self) -> None:
        for axis, rules in self._plan.run.axes.items():
            self._bench.refusals(axis)
            signals = STEPPER_SIGNALS if self._is_stepper(axis) else SERVO_SIGNALS
            rows = self._bench.sample(axis, signals, SAMPLE_NS)
            self._errors[axis] = _Errors(rows, rules.following_error_deg)

    def _unwatch(self) -> None:
        for axis, errors in self._errors.items():
            self._note(axis, errors)
            errors.rows.close()
            report = self.progress.axes[axis]
            report.position_deg = self._told(axis, "position_deg")
            report.commanded_deg = self._told(axis, "commanded_deg" if self._is_stepper(axis) else "r")

    def _told(self, axis: str, name: str) -> float | None:
        value = self._bench.field(axis, name)
        return None if isnan(value) else value
