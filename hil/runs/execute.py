"""Carries out a plan on a bench, in simulated time: a generator of times up to which nothing is to do."""

from bisect import bisect_right
from collections.abc import Generator, Mapping
from itertools import takewhile

from hil.runs.course import PhraseCourse
from hil.runs.plan import Move, Phrase, Plan
from hil.runs.progress import AxisReport, Ended, Progress
from hil.runs.run_axis import RunAxis
from hil.runs.run_document import WaitUntil
from hil.vocab.axis import NOT_JOINED, Axes, How
from hil.vocab.path import PathPiece
from hil.vocab.verbs import VerbRefused

POLL_NS = 10_000_000
"""Interval of looks at an axis while it moves."""
BEGINS_NS = 1_000_000
"""Delay until a motion by an axis's own ramps shows: from the command to the first tick of its clock."""
STAND_NS = 3_600_000_000_000
"""Time after its phrase until an axis that is not at its end has failed."""
CHECK_NS = 50_000_000
"""Interval of checks that an axis still follows the path that the run gave it."""
PACE_LEAD_NS = 30_000_000
"""Time from a change of pace to its beginning: that in which the axes get it."""
MOST_LEAD_NS = 2_000_000_000
"""Largest such time, on a computer that has much to do."""
SETTLE_NS = 200_000_000
"""Time for a shaft to come to rest after its set-point did."""
LEAST_PACE = 0.001
"""Slowest pace that is no pause: a path of a day takes three years."""
_STOPS: Mapping[How, str] = {"grace": "a controlled stop", "prejudice": "an immediate stop"}


def _stands(piece: PathPiece) -> bool:
    return not (piece.per_s or piece.per_s2 or piece.per_s3)


class Soon:
    """Starts of phrases on one bench alone: each begins ``lead_ns`` after the last has ended. The phrase
    after the last is the end, which all axes reach together."""

    is_shared = False
    """True if other benches have been told the same starts."""

    def __init__(self, clock: Axes, lead_ns: int) -> None:
        self._clock = clock
        self._lead_ns = lead_ns

    def start_ns(self, phrase: int) -> int:
        """Start of a phrase in simulated time, still to come. Asked when those before it have ended here."""
        return self._clock.now_ns + self._lead_ns


class Told:
    """Starts of phrases that others tell: ``starts_ns`` by phrase, in simulated time."""

    is_shared = True

    def __init__(self) -> None:
        self.starts_ns: dict[int, int] = {}

    def start_ns(self, phrase: int) -> int | None:
        """Start of a phrase; None: not known yet."""
        return self.starts_ns.get(phrase)


class Execution:
    """Execution of one run, or of the part of it whose axes are on this bench. ``devices``: those of the
    bench, by the names that the run has for them; ``progress``: where it reports.

    Long because a run can be stopped or paced in each of its steps.
    """

    def __init__(
        self,
        plan: Plan,
        axes: Axes,
        baton: Soon | Told,
        devices: Mapping[str, str] | None = None,
        progress: Progress | None = None,
    ) -> None:
        self.plan = plan
        self._bench = axes
        self._baton = baton
        self._devices = {axis: axis for axis in plan.run.axes} if devices is None else devices
        self._axes: dict[str, RunAxis] = {}
        self._steps_before = 0
        self._gone_ns = 0
        self._pace_lead_ns = 0
        """The same after a change that came too late; 0: as usual."""
        self.lead_ns = PACE_LEAD_NS
        """Time from a change of pace to its beginning, simulated."""
        self._asked: Ended | None = None
        self._check_from_ns = 0
        self._pace = 1.0
        self.stopping: How | None = None
        """Way in which its axes are being stopped."""
        self.ended: Ended | None = None
        """Reason for an early end; its axes may still be stopping."""
        self.reached = -1
        """Phrase whose beginning it waits for, or that has begun; all before have ended here."""
        self.progress = progress or Progress(plan.run.run, steps=plan.steps)

    def stop(self, how: How, why: str | None = None, state: str = "cancelled") -> None:
        """Stop the run, at any time. A controlled stop can become an immediate one."""
        self._asked = Ended(state, why or f"it was cancelled with {_STOPS[how]}", how)

    def set_pace(self, pace: float) -> None:
        """Slow the run down along its paths, at any time: 1 is as planned, 0 a pause. A phrase with moves or
        levels goes on as planned to its end.

        Raises:
            VerbRefused: an axis of it is a real board's, or so slow a pace there is not.
        """
        if not (pace == 0 or LEAST_PACE <= pace <= 1):
            raise VerbRefused("bad_parameter", f"pace: write 0, or {LEAST_PACE:g} to 1")
        for name, axis in self.plan.axes.items():
            if name in self.plan.run.axes and axis.follows_paths and not axis.joins_paths:
                raise VerbRefused("cannot", f"{name}: {NOT_JOINED}; cancel the run instead")
        self._pace = self.progress.pace = pace

    def run(self) -> Generator[int, None, None]:
        """Yield simulated times up to which nothing has to be done; ends when the run has."""
        progress, run = self.progress, self.plan.run
        progress.state, progress.started_at_ns = "running", self._bench.now_ns
        try:
            self._take_axes()
            if run.start_in_s:
                yield from self._until(self._bench.now_ns + round(run.start_in_s * 1e9))
            progress.planned_ns = sum(phrase.duration_ns for phrase in self.plan.phrases)
            for number, phrase in enumerate(self.plan.phrases):
                while self._pace == 0:
                    self._look()
                    yield self._bench.now_ns + POLL_NS
                start_ns = yield from self._start_of(number)
                yield from self._phrase(phrase, start_ns)
                self._gone_ns += phrase.duration_ns
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
            for axis in self._axes.values():
                axis.close()
            progress.ended_at_ns = self._bench.now_ns

    def _take_axes(self) -> None:
        run = self.plan.run
        for name, rules in run.axes.items():
            if device := self._devices.get(name):
                report = self.progress.axes[name] = AxisReport(self.plan.ends_deg[name])
                self._axes[name] = RunAxis(name, self._bench[device], rules, report, run.on_fault)

    # ---- its phrases ----

    def _start_of(self, number: int) -> Generator[int, None, int]:
        self.reached = number
        while (start_ns := self._baton.start_ns(number)) is None:
            self._look()
            yield self._bench.now_ns + POLL_NS
        return start_ns

    def _phrase(self, phrase: Phrase, start_ns: int) -> Generator[int, None, None]:
        can_join = all(self.plan.axes[name].joins_paths for name in phrase.paths)
        pace = 1.0 if phrase.events or not can_join else self._pace or 1.0
        course = PhraseCourse(phrase, start_ns, self.plan.run.axes, pace, can_join)
        course, late_ns = self._begin(course, can_join)
        if self.progress.began_at_ns is None:
            self.progress.began_at_ns = self._begins_ns(phrase, course.start_ns)
        for event in phrase.events:
            if axis := self._axes.get(event.axis):
                axis.give(event, course.start_ns)
        late_ns += BEGINS_NS if phrase.awaited else 0
        yield from self._go(phrase, course, late_ns, can_join)
        self._steps_before += len(phrase.marks)
        give_up_ns = self._bench.now_ns + STAND_NS
        while any(axis.is_under_way for name, axis in self._axes.items() if name in phrase.awaited):
            if self._bench.now_ns > give_up_ns:
                raise Ended("failed", "a stepper does not come to its end", self.plan.run.on_fault)
            yield from self._until(self._bench.now_ns + POLL_NS)
        while any(axis.is_on_the_last_of_its_path(axis.state()) for axis in self._axes.values()):
            yield from self._until(self._bench.now_ns + POLL_NS)
        self._check_ends(phrase)
        if phrase.wait and phrase.wait.axis in self._axes:
            yield from self._wait(phrase.wait)

    def _begins_ns(self, phrase: Phrase, start_ns: int) -> int | None:
        """Time at which the first of this bench's axes begins to move; None: they stand in this phrase."""
        moves_ns = [
            start_ns + event.at_ns
            for event in phrase.events
            if event.axis in self._axes and isinstance(event, Move)
        ]
        paths_ns = [
            axis.begins_ns + sum(piece.duration_ns for piece in takewhile(_stands, phrase.paths[name]))
            for name, axis in self._axes.items()
            if name in phrase.paths
        ]
        return min([*moves_ns, *paths_ns], default=None)

    def _begin(self, course: PhraseCourse, can_join: bool) -> tuple[PhraseCourse, int]:
        """Give the axes their paths. Answers the course that they have, from one start: a later one if some
        missed the one that was chosen; and how much later some end, where not all can join paths."""
        start_ns, lasts_ns = course.start_ns, (course.end_ns() or course.start_ns) - course.start_ns
        begun_ns: dict[str, int] = {}
        paths = {name: path for name, path in course.first_paths().items() if name in self._axes}
        for name, path in paths.items():
            last_deg = course.phrase.paths[name][-1].r
            begun_ns[name] = self._axes[name].follow(path, start_ns, lasts_ns, last_deg)
            if can_join and begun_ns[name] > start_ns:  # the others get theirs for another start
                break
        late_ns = max(begun_ns.values(), default=start_ns) - start_ns
        if late_ns and self._baton.is_shared:
            raise self._too_busy("the start was", late_ns)
        if not late_ns or not can_join:
            return course, late_ns
        if len(paths) == 1:
            return course.at_start(start_ns + late_ns), 0
        return self._begin_again(course, begun_ns), 0

    def _begin_again(self, course: PhraseCourse, begun_ns: Mapping[str, int]) -> PhraseCourse:
        """Let all axes of a phrase begin at another start, as some missed theirs."""
        lead_ns = self.lead_ns
        while True:
            now_ns = self._bench.now_ns
            self._check_given(course, now_ns + lead_ns)
            again, from_ns, paths = course.begin_again(begun_ns, now_ns, lead_ns)
            if self._bench.now_ns < now_ns + lead_ns or lead_ns == MOST_LEAD_NS:
                break
            lead_ns = min(2 * lead_ns, MOST_LEAD_NS)  # too late: the axes would jump
        for name, path in paths.items():
            if axis := self._axes.get(name):
                axis.join(path, from_ns, again.end_ns() or again.start_ns, course.phrase.paths[name][-1].r)
        return again

    def _check_given(self, course: PhraseCourse, now_ns: int) -> None:
        """Raise Ended if an axis is at the end of what it was given: it would seem to be stopped by
        somebody."""
        if behind_ns := course.behind_ns(now_ns):
            raise self._too_busy("more of the axes' path was due", behind_ns)

    def _too_busy(self, what: str, late_ns: int) -> Ended:
        why = f"this computer was too busy: {what} {late_ns / 1e6:.0f} ms ago"
        return Ended("failed", why, self.plan.run.on_fault)

    def _check_ends(self, phrase: Phrase) -> None:
        """Check that the axes are where the phrase leads."""
        for axis in self._axes.values():
            axis.check_path()
        for event in phrase.events:
            if event.axis in self._axes and isinstance(event, Move):
                self._axes[event.axis].check_end(event.position_deg)

    def _wait(self, wait: WaitUntil) -> Generator[int, None, None]:
        axis, give_up_ns = self._axes[wait.axis], self._bench.now_ns + round(wait.timeout_s * 1e9)
        while not self._is_met(axis.axis.field(wait.field), wait.above, wait.below):
            if self._bench.now_ns >= give_up_ns:
                raise axis.failed(f"{wait.axis}.{wait.field} was not in its range for {wait.timeout_s:g} s")
            yield from self._until(min(self._bench.now_ns + POLL_NS, give_up_ns))

    @staticmethod
    def _is_met(value: float, above: float | None, below: float | None) -> bool:
        return (above is None or value >= above) and (below is None or value <= below)

    def _go(
        self, phrase: Phrase, course: PhraseCourse, late_ns: int, can_join: bool
    ) -> Generator[int, None, None]:
        """Go along a phrase, which ends so much later than planned, at the pace that is asked for."""
        progress, looked_ns = self.progress, course.start_ns
        while True:
            now_ns = self._bench.now_ns
            self._check_given(course, now_ns)
            at_ns, end_ns = course.plan_ns(now_ns), course.end_ns()
            begun = bisect_right(phrase.marks, at_ns, key=lambda mark: mark[0])
            if begun and now_ns >= course.start_ns:
                if progress.step != self._steps_before + begun:
                    progress.step = self._steps_before + begun
                    progress.step_at_ns = course.reached_ns(phrase.marks[begun - 1][0], looked_ns, now_ns)
                looked_ns = now_ns
            progress.gone_ns = self._gone_ns + at_ns
            left_ns = progress.planned_ns - self._gone_ns - phrase.duration_ns
            progress.planned_end_ns = None if end_ns is None else end_ns + left_ns
            if self._asked and self._asked.how == "grace" and phrase.keeps_path and can_join:
                self._pace = 0.0  # it stops on its path, and ends then
                if course.stands(now_ns):
                    raise self._asked
                self._look(stops=False)
            else:
                self._look()
            self._keep_pace(course, now_ns, bool(phrase.events))
            if end_ns is not None and now_ns >= end_ns + late_ns and self._have_reached(end_ns + late_ns):
                return
            is_far = end_ns is None or now_ns >= end_ns + late_ns
            yield now_ns + POLL_NS if is_far else min(now_ns + POLL_NS, (end_ns or 0) + late_ns)

    def _keep_pace(self, course: PhraseCourse, now_ns: int, has_events: bool) -> None:
        """Give the axes a change of pace, or more of long paths."""
        if not course.is_steady(now_ns):
            return
        changes = course.pace != self._pace and not has_events
        changes = changes and course.change(self._pace, now_ns, self._pace_lead_ns or self.lead_ns)
        if changes or course.wants_more(now_ns):
            from_ns, paths = course.paths(now_ns)
            if changes and self._bench.now_ns >= course.changes_ns:  # too late: the axes would jump
                course.take_back()
                self._pace_lead_ns = min(2 * (self._pace_lead_ns or self.lead_ns), MOST_LEAD_NS)
                return
            self._pace_lead_ns = 0
            end_ns = course.end_ns()
            for name, path in paths.items():
                if axis := self._axes.get(name):
                    stands_ns = from_ns + sum(piece.duration_ns for piece in path)
                    last = (path if end_ns is None else course.phrase.paths[name])[-1]
                    axis.join(path, from_ns, stands_ns if end_ns is None else end_ns, last.r)

    def _until(self, end_ns: int) -> Generator[int, None, None]:
        while True:
            now_ns = self._bench.now_ns
            self._look()
            if now_ns >= end_ns and self._have_reached(end_ns):
                return
            yield min(now_ns + POLL_NS, end_ns) if now_ns < end_ns else now_ns + POLL_NS

    def _have_reached(self, at_ns: int) -> bool:
        """True if the axes' values are of this time or later: a board that has much to do comes behind."""
        return not any(axis.state().at_ns < at_ns for axis in self._axes.values())

    def _look(self, *, stops: bool = True) -> None:
        if self._asked and stops:
            raise self._asked
        for axis in self._axes.values():
            axis.look()
        if (now_ns := self._bench.now_ns) >= self._check_from_ns:
            self._check_from_ns = now_ns + CHECK_NS
            for axis in self._axes.values():
                axis.check_path()

    # ---- its end ----

    def _stop(self, how: How) -> Generator[int, None, None]:
        """Stop all axes of the run, whatever they do, and wait until they stand."""
        axes = self._axes.values()
        self._give_stop(how)
        give_up_ns = self._bench.now_ns + STAND_NS
        while any(axis.moves for axis in axes) and self._bench.now_ns < give_up_ns:
            if self.stopping == "grace" and self._asked and self._asked.how == "prejudice":
                self._give_stop("prejudice")
            yield self._bench.now_ns + POLL_NS
            for axis in axes:
                axis.note()
        settled_ns = self._bench.now_ns + SETTLE_NS
        while not all(axis.is_settled for axis in axes) and self._bench.now_ns < settled_ns:
            yield self._bench.now_ns + POLL_NS

    def _give_stop(self, how: How) -> None:
        self.stopping = how
        for axis in self._axes.values():
            axis.stop(how)
