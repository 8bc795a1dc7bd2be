"""Queue of a bench's runs: those accepted, those that wait, those that move, and how they ended.

The rule: a run is checked as a whole when it is submitted, from where its axes will be after the runs before
it. It starts when none of its axes is in a run that was accepted earlier and has not ended, so runs of other
axes go on beside it; it is then planned again from where the axes are. At most ``WAITING`` runs wait, later
ones are refused. A run is its name and its text. The same of both, submitted again, is the same run: its
state is answered, nothing is done twice. One name with two texts is refused. Who wants a text carried out
each time asks for a fresh name: that of the text, or that with a number. Axes of other benches are not waited
for: they have to be free when a run is submitted and when it starts.
"""

import asyncio
import logging
from collections.abc import Callable, Collection, Coroutine, Iterable, Mapping
from dataclasses import replace
from itertools import count
from typing import Any

from hil.live.configured import Configured
from hil.live.core_thread import WallClock
from hil.live.off_loop import SHORT, off_loop
from hil.live.reservations import Reservations
from hil.live.runs.carry_out import CarryingOut, NotBegun, QueuedRun
from hil.live.runs.lead import Together
from hil.live.runs.other_benches import OtherBenches
from hil.live.runs.planning import Planning
from hil.runs import Execution, Plan, Progress, plan_points
from hil.runs.run_document import DOCUMENT_BYTES
from hil.vocab.axis import Axes, AxisNow, How
from hil.vocab.desk_protocol import Source
from hil.vocab.near_words import meant
from hil.vocab.text_digest import text_digest
from hil.vocab.verbs import VerbRefused

log = logging.getLogger("hil")

NAME_CHARACTERS = 32
"""Maximum length of a name, as ``hil.vocab.address.NAME_PATTERN`` has it."""
NAMED = 5
"""Maximum number of runs that are named in a refusal: the last ones."""
WAITING = 1000
KEPT = 1000
"""Maximum number of ended runs that are kept; older ones are forgotten."""
WAITING_CHARACTERS = 32 << 20
"""Maximum length of all runs together that wait or move."""
ERROR_OF_OURS = "an error of hil; its log has more"


Doing = Callable[[QueuedRun], Coroutine[Any, Any, None]]
"""Work on a run; not begun where it is cancelled before."""


class RunQueue:
    """Runs of one bench. ``axes``: its twins and real boards; ``others``: benches that it can lead.

    Long because a run that waits, begins, ends or is cancelled changes which others may begin.
    """

    def __init__(
        self,
        axes: Axes,
        configured: Configured,
        wall: WallClock,
        others: OtherBenches,
        reservations: Reservations,
    ) -> None:
        self._axes = axes
        self._configured = configured
        self._reservations = reservations
        self._planning = Planning(axes, configured, wall, others)
        self._carrying_out = CarryingOut(axes, self._planning, configured, self._tell)
        self._entries: dict[str, QueuedRun] = {}
        self._is_closed = False
        self._starts_soon = False
        self.progress: dict[str, Progress] = {}
        """Progress of all runs that are remembered, by name, in the order of their submission."""
        self.listeners: list[Callable[[Progress], None]] = []
        """Called when a run's state or step changes, and ten times a second while it moves."""

    # ---- what others ask for ----

    def submit(
        self, source: Source, text: str, file: str = "<run>", *, name: str = "", fresh: bool = False
    ) -> Progress | asyncio.Task[Progress]:
        """Accept a run, or answer the progress of the one of this name and text: at once, unless the run is
        long, or has axes of other benches. ``name`` stands in the place of its own; ``fresh``: it gets one
        that no run has.

        Raises (at once, or from the task):
            ConfigError: it cannot be done, with all problems.
            VerbRefused: not now.
        """
        _refuse(text, self._entries.values())
        if len(text) <= SHORT:
            run, document = self._planning.read_all(text, file, name, self._expected)
            if not self._planning.is_shared(run):
                if known := self._known(run.run, text, fresh):
                    return known
                plan = self._planning.plan(run, document, self._expected())
                return self._accept(source, text, file, (plan, None), fresh)
        return asyncio.get_running_loop().create_task(self._submit_later(source, text, file, name, fresh))

    def left(self, progress: Progress) -> dict[str, float | None]:
        """Time until a run's planned end, simulated and in seconds of the wall; None: it is not known."""
        if progress.state != "running" or progress.planned_end_ns is None:
            return {"left_ns": None, "left_s": None}
        left_ns = max(progress.planned_end_ns - self._axes.now_ns, 0)
        return {"left_ns": left_ns, "left_s": left_ns / 1e9 / self._configured.config.speed}

    def under_way(self) -> list[dict[str, Any]]:
        """List the runs that wait or move, in the order of their submission."""
        keys = ("run", "state", "step", "steps", "why")
        return [
            {key: getattr(entry.progress, key) for key in keys} | self.left(entry.progress)
            for entry in self._entries.values()
        ]

    def devices_of(self, name: str) -> Collection[str]:
        """Axes of a run that waits or moves, by their addresses; none of any other."""
        entry = self._entries.get(name)
        return entry.devices if entry else ()

    async def check(self, source: Source, text: str, file: str, points: int = 0) -> dict[str, Any]:
        """Check that a run can be done, without doing it; raises as ``submit``. ``points``: answer so many
        points of its plan at most."""
        _refuse(text, self._entries.values())
        plan, _ = await self._planning.plan_text(source, text, file, self._expected)
        answer: dict[str, Any] = {"run": plan.run.run, "steps": plan.steps}
        return answer | ({"plan": await off_loop(text, plan_points, plan, points)} if points else {})

    def cancel(self, name: str, how: How) -> Progress:
        """End a run; one that waits never starts. Raises VerbRefused: there is none."""
        if name not in self.progress:
            raise no_run(name, self.progress)
        progress = self.progress[name]
        if progress.is_over:
            return progress
        entry = self._entries[name]
        if entry.execution is not None:
            entry.execution.stop(how)
        else:
            if entry.task:
                entry.task.cancel()
            self._end(entry, "cancelled", "it was cancelled before it began")
        return progress

    def set_pace(self, name: str, pace: float) -> Progress:
        """Slow a run down along its paths; 0 pauses it, 1 is as planned.

        Raises:
            VerbRefused: it does not move yet, or other benches or real boards take part.
        """
        if name not in self.progress:
            raise no_run(name, self.progress)
        if (progress := self.progress[name]).is_over:
            return progress
        if (entry := self._entries[name]).execution is None:
            raise VerbRefused("not_now", f"the run {name} waits: it can be slowed down when it moves")
        if entry.is_shared:
            raise VerbRefused("cannot", f"the run {name} spans benches; cancel it instead")
        entry.execution.set_pace(pace)
        return progress

    async def close(self) -> None:
        """End what moves, as the bench ends."""
        self._is_closed = True
        tasks = [entry.task for entry in self._entries.values() if entry.task]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    # ---- for parts of runs that another bench leads ----

    def is_under_way(self, name: str) -> bool:
        """True while the run waits, moves, or is just ending: no other run can have its name."""
        return name in self._entries

    def hold(
        self,
        source: Source,
        text: str,
        names: Mapping[str, str],
        execution: Execution,
        each: Callable[[], None],
    ) -> None:
        """Begin a part now; ``each`` is called at every look at it."""
        ends_deg = {device: execution.plan.ends_deg[axis] for axis, device in names.items()}
        entry = QueuedRun(
            text, "<run>", source, names, ends_deg, execution.progress, True, execution=execution
        )
        self._remember(entry)
        self._begin(entry, lambda entry: self._carrying_out.follow(entry, execution, each))

    # ---- accepting ----

    def _known(self, name: str, text: str, fresh: bool) -> Progress | None:
        known = self.progress.get(name)
        if known is None or fresh:
            return None
        if known.digest != text_digest(text):
            why = f"the run {name} has another text, and is {known.state}"
            raise VerbRefused("not_now", f"{why}: give this one another name")
        known.submissions += 1
        return known

    def _fresh(self, name: str) -> str:
        """Name that no run has: this one, or with the first number that is free."""
        if name not in self.progress:
            return name
        numbered = (f"{name[: NAME_CHARACTERS - len(end)]}{end}" for end in map("-{}".format, count(2)))
        return next(each for each in numbered if each not in self.progress)

    def _expected(self) -> dict[str, AxisNow]:
        """Axes as they will be when the runs before have ended."""
        axes = self._axes.axes()
        for entry in self._entries.values():
            for device, position_deg in entry.ends_deg.items():
                axes[device] = replace(axes[device], position_deg=position_deg, why_not=None)
        return axes

    async def _submit_later(self, source: Source, text: str, file: str, name: str, fresh: bool) -> Progress:
        planned = await self._planning.plan_text(source, text, file, self._expected, name)
        _refuse(text, self._entries.values())  # others were submitted meanwhile
        known = self._known(planned[0].run.run, text, fresh)
        return known or self._accept(source, text, file, planned, fresh)

    def _accept(
        self, source: Source, text: str, file: str, planned: tuple[Plan, Together | None], fresh: bool
    ) -> Progress:
        plan, _ = planned
        names, is_shared = self._planning.names(plan.run), self._planning.is_shared(plan.run)
        ends_deg = {device: plan.ends_deg[axis] for axis, device in names.items()}
        name = self._fresh(plan.run.run) if fresh else plan.run.run
        progress = Progress(name, steps=plan.steps)
        entry = QueuedRun(text, file, source, names, ends_deg, progress, is_shared)
        entry.planned = planned if is_shared else None
        self._remember(entry)
        self._start_what_can()
        if entry.task is None:  # it waits, and is planned again; a plan takes much room
            entry.planned = None
        return progress

    def _remember(self, entry: QueuedRun) -> None:
        """Remember a run in the place of one of its name that has ended."""
        self.progress.pop(entry.name, None)
        self._entries[entry.name], self.progress[entry.name] = entry, entry.progress
        self._reservations.reserve(entry.name, entry.devices)
        entry.progress.digest = text_digest(entry.text)

    # ---- beginning and ending ----

    def _start_what_can(self) -> None:
        """Start the runs whose axes have become free."""
        if self._is_closed:
            return
        self._starts_soon = False
        taken: set[str] = set()
        for entry in self._entries.values():
            if entry.task is None and not taken & entry.devices:
                self._begin(entry, self._carrying_out.run)
            taken |= entry.devices

    def _begin(self, entry: QueuedRun, doing: Doing) -> None:
        entry.task = asyncio.get_running_loop().create_task(self._attend(entry, doing))

    async def _attend(self, entry: QueuedRun, doing: Doing) -> None:
        try:
            await doing(entry)
        except NotBegun as error:
            self._end(entry, "failed", str(error))
        except Exception:  # hil's own error: this run has failed and says so, all else goes on
            log.exception("run %s", entry.name)
            self._end(entry, "failed", ERROR_OF_OURS)
        else:
            self._over(entry)

    def _end(self, entry: QueuedRun, state: str, why: str) -> None:
        """End a run that did not come to its end by itself."""
        progress = entry.progress
        progress.state, progress.why = state, why
        progress.ended_at_ns = self._axes.now_ns
        self._over(entry)

    def _over(self, entry: QueuedRun) -> None:
        """Clear up after a run that has ended; others may begin."""
        del self._entries[entry.name]
        self._reservations.release(entry.name)
        ended = [name for name, progress in self.progress.items() if progress.is_over]
        for name in ended[: max(len(ended) - KEPT, 0)]:
            del self.progress[name]
        self._tell(entry.progress)
        if not self._starts_soon:  # not here: of hundreds that wait each may fail as it starts
            self._starts_soon = True
            asyncio.get_running_loop().call_soon(self._start_what_can)

    def _tell(self, progress: Progress) -> None:
        for listener in self.listeners:
            listener(progress)


def no_run(name: str, known: Iterable[str]) -> VerbRefused:
    """Refusal of a name that no run has."""
    last = [*known][-NAMED:]
    there = f"there are {', '.join(last) or 'none'}; `hil run list` lists them"
    return VerbRefused("no_run", f"there is no run {name!r}; {meant(name, [*known], there)}")


def _refuse(text: str, waiting: Collection[QueuedRun]) -> None:
    if len(text) > DOCUMENT_BYTES:
        raise VerbRefused("bad_request", f"{len(text)} characters; a run has at most {DOCUMENT_BYTES}")
    characters = sum(len(entry.text) for entry in waiting)
    if len(waiting) >= WAITING or characters + len(text) > WAITING_CHARACTERS:
        raise VerbRefused("not_now", f"{len(waiting)} runs wait already; submit it again later")
