"""Runs in the daemon: which are accepted, which wait, which move, and what became of them.

The rule: a run is checked as a whole when it is submitted, from where its axes will be after the runs before
it. It starts when none of its axes is in a run that was accepted earlier and has not ended, so runs of other
axes go on beside it; it is then planned anew from where the axes are. At most ``WAITING`` runs wait, later
ones are refused. A run is its name and its text. The same of both, submitted again, is the same run: its
state is answered, nothing is done twice; after its end a person who asks for it anew gets it anew, where a
client that was cut off gets its end. One name with two texts is refused while the first is under way. Axes of
other benches are not waited for: they have to be free when a run is submitted and when it starts.
"""

import asyncio
import hashlib
import logging
from collections.abc import Callable, Coroutine, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from hil.config import ConfigError
from hil.config.document import Document
from hil.live.off_loop import SHORT, off_loop
from hil.live.runs import real as real_axes
from hil.live.runs.lead import Together
from hil.live.runs.names import device_names, other_benches, taken_twice
from hil.live.runs.part import Parts
from hil.live.runs.real import AllAxes, RealAxes
from hil.runs import BenchAxes, Execution, Named, Plan, Progress, RunDocument, Soon, parse_run, plan_run
from hil.runs.document import DOCUMENT_BYTES
from hil.runs.execute import How
from hil.runs.plan import AxisNow
from hil.vocab.benches import BenchGone
from hil.vocab.bridges import Source
from hil.vocab.verbs import Role, VerbRefused

if TYPE_CHECKING:
    from hil.daemon import Daemon

log = logging.getLogger("hil")

WAITING = 1000
KEPT = 1000
"""Of runs that have ended; older ones are forgotten."""
WAITING_CHARACTERS = 32 << 20
"""Of all runs that wait or move."""
LEAD_WALL_NS = 20_000_000
"""Between the giving of a phrase and its start: 32 axes are given theirs in a tenth of it."""
ERROR_OF_OURS = "an error of hil; its log has more"
TELL_S = 0.1
"""Between two tellings of a run whose state and step are as they were."""


@dataclass
class Entry:
    """A run that was accepted and has not ended. ``names``: the devices here that take part, by their names
    in the run; ``ends_deg``: where it leaves them. Of the document only the text is kept: read, a long one
    takes forty times the room."""

    name: str
    text: str
    file: str
    source: Source
    names: Mapping[str, str]
    ends_deg: Mapping[str, float]
    is_shared: bool
    """Other benches take part."""
    execution: Execution | None = None
    task: asyncio.Task[None] | None = None

    @property
    def devices(self) -> set[str]:
        return set(self.names.values())


class Runs:
    """Of one daemon."""

    def __init__(self, daemon: "Daemon") -> None:
        self._daemon = daemon
        self.real = RealAxes(daemon)
        self.axes = AllAxes(BenchAxes(daemon.bench, daemon.watches.sampler), self.real)
        self.parts = Parts(daemon, self)
        self._entries: dict[str, Entry] = {}
        self._is_closed = False
        self._starts_soon = False
        self._releasing: set[asyncio.Task[None]] = set()
        self.progress: dict[str, Progress] = {}
        """Of all runs that are remembered, by name, in the order of their submission."""
        self._digests: dict[str, bytes] = {}
        """Of their texts."""
        self.listeners: list[Callable[[Progress], None]] = []
        """Called when a run's state or step changes, and ten times a second while it moves."""

    # ---- what others ask for ----

    def submit(
        self, source: Source, text: str, file: str = "<run>", *, anew: bool = False
    ) -> Progress | Coroutine[Any, Any, Progress]:
        """Accept a run, or tell how the one of this name and text does; a long one, and one that has axes of
        other benches, have to be awaited. ``anew``: one that has ended is carried out again, with whatever
        text it has now.

        Raises:
            ConfigError: it cannot be done, with all problems.
            VerbRefused: not by this source, or not now.
        """
        self._refuse(source, text)
        if len(text) > SHORT:
            return self._submit_later(source, text, file, anew)
        run, document = self._parsed(text, file)
        if other_benches(run, self._daemon.config.bench):
            return self._submit_later(source, text, file, anew)
        if known := self._known(run.run, text, anew):
            return known
        plan = plan_run(run, document, self._by_name(self._names(run), self._expected()))
        return self._accept(source, text, file, plan, is_shared=False)

    async def check(self, source: Source, text: str, file: str) -> dict[str, Any]:
        """Whether it can be done, without doing it; raises as ``submit``."""
        self._refuse(source, text)
        plan = await self._planned(source, text, file, self._expected)
        return {"run": plan.run.run, "steps": plan.steps}

    def cancel(self, source: Source, name: str, how: How) -> Progress:
        """End a run; one that waits never starts.

        Raises:
            VerbRefused: there is none, or not by this source.
        """
        if source.role < Role.OPERATOR:
            raise VerbRefused("forbidden", "this needs the role operator")
        if name not in self.progress:
            raise VerbRefused("no_run", f"there is no run {name!r}")
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

    async def close(self) -> None:
        """The bench ends, and with it what moves."""
        self._is_closed = True
        tasks = [entry.task for entry in self._entries.values() if entry.task]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await self.real.close()

    # ---- for parts of runs that another bench leads ----

    def is_under_way(self, name: str) -> bool:
        """It waits, moves, or is just ending: nothing else can have its name."""
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
        name = execution.plan.run.run
        self._enter(Entry(name, text, "<run>", source, names, ends_deg, True), execution, each)

    def _enter(self, entry: Entry, execution: Execution, each: Callable[[], None]) -> None:
        entry.execution = execution
        self._remember(entry, execution.progress)
        entry.task = asyncio.get_running_loop().create_task(self._carry_out(entry, execution, each))

    def _end(self, entry: Entry, state: str, why: str) -> None:
        """Of a run that never moved."""
        progress = self.progress[entry.name]
        progress.state, progress.why = state, why
        progress.ended_at_ns = self._daemon.bench.now_ns
        self._over(entry)

    def _over(self, entry: Entry) -> None:
        """It has ended, and others may begin."""
        del self._entries[entry.name]
        self._daemon.holds.release(entry.name)
        ended = [name for name, progress in self.progress.items() if progress.is_over]
        for name in ended[: max(len(ended) - KEPT, 0)]:
            del self.progress[name], self._digests[name]
        if entry.name in self.progress:
            self.tell(self.progress[entry.name])
        if not self._starts_soon:  # not here: of hundreds that wait each may fail as it starts
            self._starts_soon = True
            asyncio.get_running_loop().call_soon(self._start_what_can)

    def tell(self, progress: Progress) -> None:
        for listener in self.listeners:
            listener(progress)

    # ---- accepting ----

    def _refuse(self, source: Source, text: str) -> None:
        if source.role < Role.OPERATOR:
            raise VerbRefused("forbidden", "a run needs the role operator")
        if len(text) > DOCUMENT_BYTES:
            raise VerbRefused("bad_request", f"{len(text)} characters; a run has at most {DOCUMENT_BYTES}")
        characters = sum(len(entry.text) for entry in self._entries.values())
        if len(self._entries) >= WAITING or characters + len(text) > WAITING_CHARACTERS:
            raise VerbRefused("not_now", f"{len(self._entries)} runs wait already; submit it again later")

    def _parsed(self, text: str, file: str) -> tuple[RunDocument, Document]:
        run, document = parse_run(text, file)
        if findings := taken_twice(run, self._daemon.config.bench):
            raise document.error(findings)
        return run, document

    def _known(self, name: str, text: str, anew: bool) -> Progress | None:
        known, under_way = self.progress.get(name), self.is_under_way(name)
        if known is None or (anew and not under_way):
            return None
        if self._digests[name] != _digest(text):
            wait = "wait for its end, or cancel it, or " if under_way else ""
            why = f"the run {name} has another text, and is {known.state}"
            raise VerbRefused("not_now", f"{why}: {wait}give this one another name")
        if anew and known.is_over:
            raise VerbRefused("not_now", f"the run {name} is just ending: submit it again")
        known.submissions += 1
        return known

    def _remember(self, entry: Entry, progress: Progress) -> None:
        """In the place of one of its name that has ended."""
        self.progress.pop(entry.name, None)
        self._entries[entry.name], self.progress[entry.name] = entry, progress
        self._daemon.holds.take(entry.name, entry.devices)
        self._digests[entry.name] = _digest(entry.text)

    def _names(self, run: RunDocument) -> dict[str, str]:
        return device_names(run, self._daemon.config.bench)

    def _expected(self) -> dict[str, AxisNow]:
        """The axes as they will be when the runs before have ended."""
        axes = self.axes.axes()
        for entry in self._entries.values():
            for device, position_deg in entry.ends_deg.items():
                axes[device] = replace(axes[device], position_deg=position_deg, why_not=None)
        return axes

    @staticmethod
    def _by_name(names: Mapping[str, str], axes: Mapping[str, AxisNow]) -> dict[str, AxisNow]:
        """As the run names them; those it names wrongly are looked for among all."""
        return dict(axes) | {name: axes[device] for name, device in names.items() if device in axes}

    async def _planned(
        self,
        source: Source,
        text: str,
        file: str,
        axes: Callable[[], Mapping[str, AxisNow]],
        together: Together | None = None,
    ) -> Plan:
        """Read and planned from where the axes are, in a thread if that takes long."""
        run, document = await off_loop(text, self._parsed, text, file)
        if other_benches(run, self._daemon.config.bench):
            together = together or Together(self._daemon, source, run)
            others = await together.look(document)
        else:
            others = {}
        now = self._by_name(self._names(run), axes()) | others
        return await off_loop(text, plan_run, run, document, now)

    async def _submit_later(self, source: Source, text: str, file: str, anew: bool) -> Progress:
        plan = await self._planned(source, text, file, self._expected)
        self._refuse(source, text)  # others were submitted meanwhile
        if known := self._known(plan.run.run, text, anew):
            return known
        is_shared = bool(other_benches(plan.run, self._daemon.config.bench))
        return self._accept(source, text, file, plan, is_shared)

    def _accept(self, source: Source, text: str, file: str, plan: Plan, is_shared: bool) -> Progress:
        name, names = plan.run.run, self._names(plan.run)
        ends_deg = {device: plan.ends_deg[axis] for axis, device in names.items()}
        progress = Progress(name, steps=plan.steps)
        self._remember(Entry(name, text, file, source, names, ends_deg, is_shared), progress)
        self._start_what_can()
        return self.progress.get(name, progress)

    # ---- carrying out ----

    def _start_what_can(self) -> None:
        """Those whose axes have become free; where one fails at once, those behind it come soon."""
        if self._is_closed:
            return
        self._starts_soon = False
        taken: set[str] = set()
        for entry in list(self._entries.values()):
            if entry.task is None and not taken & entry.devices:
                self._start(entry)
            taken |= entry.devices

    def _start(self, entry: Entry) -> None:
        if entry.is_shared or len(entry.text) > SHORT:
            begin = self._lead(entry) if entry.is_shared else self._begin(entry)
            entry.task = asyncio.get_running_loop().create_task(self._guarded(entry, begin))
            return
        try:
            run, document = parse_run(entry.text, entry.file)
            plan = plan_run(run, document, self._by_name(entry.names, self.axes.axes()))
        except ConfigError as error:
            self._end(entry, "failed", f"it cannot be done any more: {error}")
            return
        except Exception:  # ours: those behind it must not wait for ever
            self._failed_by_us(entry)
            return
        self._enter(entry, self._execution(entry, plan), _nothing)

    def _execution(self, entry: Entry, plan: Plan) -> Execution:
        named = Named(self.axes, entry.names)
        is_real = any(plan.axes[axis].is_real for axis in plan.run.axes)
        lead_wall_ns = real_axes.LEAD_WALL_NS if is_real else LEAD_WALL_NS
        return Execution(plan, named, Soon(named, round(lead_wall_ns * self._daemon.config.speed)))

    async def _begin(self, entry: Entry) -> None:
        """A long one of this bench alone."""
        try:
            plan = await self._planned(entry.source, entry.text, entry.file, self.axes.axes)
            self._refuse_moved(entry, plan)
        except (ConfigError, VerbRefused) as error:
            self._end(entry, "failed", f"it cannot be done any more: {error}")
            return
        self._enter(entry, self._execution(entry, plan), _nothing)

    async def _guarded(self, entry: Entry, begin: Coroutine[Any, Any, None]) -> None:
        try:
            await begin
        except Exception:  # ours, before it moved: as in _carry_out
            self._failed_by_us(entry)

    def _failed_by_us(self, entry: Entry) -> None:
        log.exception("run %s", entry.name)
        if entry.name in self._entries:
            self._end(entry, "failed", ERROR_OF_OURS)

    def _refuse_moved(self, entry: Entry, plan: Plan) -> None:
        """Axes have to be where they were when the plan was made."""
        axes = self.axes.axes()
        for name, device in entry.names.items():
            if why := axes[device].why_not:
                raise VerbRefused("not_now", f"{name}: {why}")
            if axes[device].position_deg != plan.axes[name].position_deg:
                raise VerbRefused("not_now", f"{name} was moved while the run was planned")

    async def _lead(self, entry: Entry) -> None:
        """A run that spans benches, of which this is the one that leads."""
        together: Together | None = None
        try:
            run, _ = await off_loop(entry.text, parse_run, entry.text, entry.file)
            together = Together(self._daemon, entry.source, run)
            plan = await self._planned(entry.source, entry.text, entry.file, self.axes.axes, together)
            self._refuse_moved(entry, plan)
            await together.join(entry.text, plan)
        except (ConfigError, VerbRefused, BenchGone) as error:
            if together:
                await together.release()
            self._end(entry, "failed", f"it did not begin: {error}")
            return
        except asyncio.CancelledError:
            if together:
                releasing = asyncio.get_running_loop().create_task(together.release())
                self._releasing.add(releasing)
                releasing.add_done_callback(self._releasing.discard)
            raise
        entry.execution = Execution(plan, Named(self.axes, entry.names), together.baton, set(entry.names))
        together.begin(entry.execution, self.progress[entry.name])
        await self._carry_out(entry, entry.execution, together.each, together)

    async def _carry_out(
        self, entry: Entry, execution: Execution, each: Callable[[], None], together: Together | None = None
    ) -> None:
        bench, speed, loop = (
            self._daemon.bench,
            self._daemon.config.speed,
            asyncio.get_running_loop(),
        )
        progress = self.progress[entry.name]
        told, told_s = ("", -1), loop.time()
        try:
            for until_ns in execution.run():
                each()
                if (progress.state, progress.step) != told or loop.time() - told_s >= TELL_S:
                    told, told_s = (progress.state, progress.step), loop.time()
                    self.tell(progress)
                await asyncio.sleep(max((until_ns - bench.now_ns) / 1e9 / speed, 0.0))
            if together:
                await together.finish()
        except Exception:  # ours: this run has failed and says so, all else goes on
            log.exception("run %s", entry.name)
            progress.state, progress.why = "failed", ERROR_OF_OURS
        finally:
            if together:
                together.leave()
            self._over(entry)


def _digest(text: str) -> bytes:
    return hashlib.sha256(text.encode(errors="surrogatepass")).digest()


def _nothing() -> None:
    pass
