"""Runs in the daemon: which are accepted, which wait, which move, and what became of them.

The rule: a run is checked as a whole when it is submitted, from where its axes will be after the runs before
it. It starts when none of its axes is in a run that was accepted earlier and has not ended, so runs of other
axes go on beside it; it is then planned anew from where the axes are. At most ``WAITING`` runs wait, later
ones are refused. The same name submitted again is the same run: its state is answered, nothing is done twice.
Axes of other benches are not waited for: they have to be free when a run is submitted and when it starts.
"""

import asyncio
import logging
from collections.abc import Callable, Coroutine, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from hil.config import ConfigError
from hil.config.document import Document
from hil.daemon import real_axes
from hil.daemon.joined import device_names, other_benches, taken_twice
from hil.daemon.parts import Parts
from hil.daemon.real_axes import AllAxes, RealAxes
from hil.daemon.together import Together
from hil.runs import BenchAxes, Execution, Named, Progress, RunDocument, Soon, parse_run, plan_run
from hil.runs.document import DOCUMENT_BYTES
from hil.runs.execute import How
from hil.runs.plan import AxisNow
from hil.vocab.benches import BenchGone
from hil.vocab.bridges import Source
from hil.vocab.verbs import Role, VerbRefused

if TYPE_CHECKING:
    from hil.daemon.daemon import Daemon

log = logging.getLogger("hil")

WAITING = 1000
KEPT = 1000
"""Of runs that have ended; older ones are forgotten."""
LEAD_WALL_NS = 20_000_000
"""Between the giving of a phrase and its start: 32 axes are given theirs in a tenth of it."""
TELL_S = 0.1
"""Between two tellings of a run whose state and step are as they were."""


@dataclass
class Entry:
    """A run that was accepted. ``ends_deg``: by device of this bench. ``names``: the devices here that take
    part, by their names in the run."""

    run: RunDocument
    document: Document
    text: str
    source: Source
    names: Mapping[str, str]
    ends_deg: Mapping[str, float]
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
        self._releasing: set[asyncio.Task[None]] = set()
        self.progress: dict[str, Progress] = {}
        """Of all runs that are remembered, by name, in the order of their submission."""
        self.listeners: list[Callable[[Progress], None]] = []
        """Called when a run's state or step changes, and ten times a second while it moves."""

    # ---- what others ask for ----

    def submit(
        self, source: Source, text: str, file: str = "<run>"
    ) -> Progress | Coroutine[Any, Any, Progress]:
        """Accept a run, or tell how the one of this name does; one that has axes of other benches has to be
        awaited.

        Raises:
            ConfigError: it cannot be done, with all problems.
            VerbRefused: not by this source, or not now.
        """
        run, document = self._read(source, text, file)
        if run.run in self.progress:
            return self.progress[run.run]
        if sum(progress.state == "queued" for progress in self.progress.values()) >= WAITING:
            raise VerbRefused("not_now", f"{WAITING} runs wait already; submit it again later")
        entry = self._entry(source, run, document, text)
        if other_benches(run, self._daemon.config.bench):
            return self._submit_together(entry)
        return self._accept(entry, self._expected())

    def check(
        self, source: Source, text: str, file: str
    ) -> dict[str, Any] | Coroutine[Any, Any, dict[str, Any]]:
        """Whether it can be done, without doing it; as ``submit``."""
        run, document = self._read(source, text, file)
        entry = self._entry(source, run, document, text)
        if other_benches(run, self._daemon.config.bench):
            return self._check_together(entry)
        return self._checked(entry, self._expected())

    def cancel(self, source: Source, name: str, how: How) -> Progress:
        """End a run; one that waits never starts.

        Raises:
            VerbRefused: there is none, or not by this source.
        """
        if source.role < Role.OPERATOR:
            raise VerbRefused("forbidden", "this needs the role operator")
        if name not in self.progress:
            raise VerbRefused("no_run", f"there is no run {name!r}")
        progress, entry = self.progress[name], self._entries[name]
        if progress.is_over:
            return progress
        if entry.execution is not None:
            entry.execution.stop(how)
        else:
            if entry.task:
                entry.task.cancel()
            self.end(progress, "cancelled", "it was cancelled before it began")
            self.start_what_can()
        return progress

    async def close(self) -> None:
        """The bench ends, and with it what moves."""
        tasks = [entry.task for entry in self._entries.values() if entry.task]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await self.real.close()

    # ---- for parts of runs that another bench leads ----

    def taken(self) -> dict[str, str]:
        """Devices that are in a run or will be, and in which."""
        return {
            device: name
            for name, entry in self._entries.items()
            if not self.progress[name].is_over
            for device in entry.devices
        }

    def hold(
        self,
        source: Source,
        text: str,
        document: Document,
        names: Mapping[str, str],
        execution: Execution,
        each: Callable[[], None],
    ) -> None:
        """Begin a part now; ``each`` is called at every look at it."""
        ends_deg = {device: execution.plan.ends_deg[axis] for axis, device in names.items()}
        self._enter(Entry(execution.plan.run, document, text, source, names, ends_deg), execution, each)

    def _enter(self, entry: Entry, execution: Execution, each: Callable[[], None]) -> None:
        name = entry.run.run
        entry.execution = execution
        self._entries[name], self.progress[name] = entry, execution.progress
        self._forget()
        entry.task = asyncio.get_running_loop().create_task(self._carry_out(entry, execution, each))

    def end(self, progress: Progress, state: str, why: str) -> None:
        """Of a run that never moved."""
        progress.state, progress.why = state, why
        progress.ended_at_ns = self._daemon.bench.now_ns
        self.tell(progress)

    def tell(self, progress: Progress) -> None:
        for listener in self.listeners:
            listener(progress)

    # ---- accepting ----

    def _read(self, source: Source, text: str, file: str) -> tuple[RunDocument, Document]:
        if source.role < Role.OPERATOR:
            raise VerbRefused("forbidden", "a run needs the role operator")
        if len(text) > DOCUMENT_BYTES:
            raise VerbRefused("bad_request", f"{len(text)} characters; a run has at most {DOCUMENT_BYTES}")
        run, document = parse_run(text, file)
        if findings := taken_twice(run, self._daemon.config.bench):
            raise document.error(findings)
        return run, document

    def _entry(self, source: Source, run: RunDocument, document: Document, text: str) -> Entry:
        return Entry(run, document, text, source, device_names(run, self._daemon.config.bench), {})

    def _expected(self) -> dict[str, AxisNow]:
        """The axes as they will be when the runs before have ended."""
        axes = self.axes.axes()
        for name, entry in self._entries.items():
            if not self.progress[name].is_over:
                for device, position_deg in entry.ends_deg.items():
                    axes[device] = replace(axes[device], position_deg=position_deg, why_not=None)
        return axes

    def _by_name(self, entry: Entry, axes: Mapping[str, AxisNow]) -> dict[str, AxisNow]:
        """As the run names them; those it names wrongly are looked for among all."""
        return dict(axes) | {name: axes[device] for name, device in entry.names.items() if device in axes}

    def _checked(self, entry: Entry, axes: Mapping[str, AxisNow]) -> dict[str, Any]:
        return {
            "run": entry.run.run,
            "steps": plan_run(entry.run, entry.document, self._by_name(entry, axes)).steps,
        }

    async def _check_together(self, entry: Entry) -> dict[str, Any]:
        others = await Together(self._daemon, entry.source, entry.run, entry.document).look()
        return self._checked(entry, self._expected() | others)

    async def _submit_together(self, entry: Entry) -> Progress:
        others = await Together(self._daemon, entry.source, entry.run, entry.document).look()
        if entry.run.run in self.progress:  # submitted again meanwhile
            return self.progress[entry.run.run]
        return self._accept(entry, self._expected() | others)

    def _accept(self, entry: Entry, axes: Mapping[str, AxisNow]) -> Progress:
        plan = plan_run(entry.run, entry.document, self._by_name(entry, axes))
        name = entry.run.run
        entry.ends_deg = {device: plan.ends_deg[axis] for axis, device in entry.names.items()}
        self._entries[name] = entry
        self.progress[name] = progress = Progress(name, steps=plan.steps)
        self._forget()
        self.start_what_can()
        return self.progress.get(name, progress)

    # ---- carrying out ----

    def start_what_can(self) -> None:
        """Those whose axes have become free."""
        taken: set[str] = set()
        for name, entry in list(self._entries.items()):
            if self.progress[name].is_over:
                continue
            if entry.task is None and not taken & entry.devices:
                self._start(entry)
            if not self.progress[name].is_over:
                taken |= entry.devices

    def _start(self, entry: Entry) -> None:
        bench = self._daemon.config.bench
        if other_benches(entry.run, bench):
            entry.task = asyncio.get_running_loop().create_task(self._lead(entry))
            return
        try:
            plan = plan_run(entry.run, entry.document, self._by_name(entry, self.axes.axes()))
        except ConfigError as error:
            self.end(self.progress[entry.run.run], "failed", f"it cannot be done any more: {error}")
            return
        named = Named(self.axes, entry.names)
        is_real = any(plan.axes[axis].is_real for axis in entry.run.axes)
        lead_wall_ns = real_axes.LEAD_WALL_NS if is_real else LEAD_WALL_NS
        self._enter(
            entry,
            Execution(plan, named, Soon(named, round(lead_wall_ns * self._daemon.config.speed))),
            _nothing,
        )

    async def _lead(self, entry: Entry) -> None:
        """A run that spans benches, of which this is the one that leads."""
        progress = self.progress[entry.run.run]
        together = Together(self._daemon, entry.source, entry.run, entry.document)
        try:
            others = await together.look()
            plan = plan_run(entry.run, entry.document, self._by_name(entry, self.axes.axes()) | others)
            await together.join(entry.text, plan)
        except (ConfigError, VerbRefused, BenchGone) as error:
            await together.release()
            self.end(progress, "failed", f"it did not begin: {error}")
            self.start_what_can()
            return
        except asyncio.CancelledError:
            releasing = asyncio.get_running_loop().create_task(together.release())
            self._releasing.add(releasing)
            releasing.add_done_callback(self._releasing.discard)
            raise
        entry.execution = Execution(plan, Named(self.axes, entry.names), together.baton, set(entry.names))
        together.begin(entry.execution, progress)
        await self._carry_out(entry, entry.execution, together.each, together)

    async def _carry_out(
        self, entry: Entry, execution: Execution, each: Callable[[], None], together: Together | None = None
    ) -> None:
        bench, speed, loop = self._daemon.bench, self._daemon.config.speed, asyncio.get_running_loop()
        progress = self.progress[entry.run.run]
        told, told_s = ("", -1), loop.time()
        try:
            for until_ns in execution.run():
                each()
                self._daemon.lines.flush()
                if (progress.state, progress.step) != told or loop.time() - told_s >= TELL_S:
                    told, told_s = (progress.state, progress.step), loop.time()
                    self.tell(progress)
                await asyncio.sleep(max((until_ns - bench.now_ns) / 1e9 / speed, 0.0))
            if together:
                await together.finish()
        except Exception:  # ours: this run has failed and says so, all else goes on
            log.exception("run %s", entry.run.run)
            progress.state, progress.why = "failed", "an error of hil; its log has more"
        finally:
            if together:
                together.leave()
            entry.execution = None
            self._daemon.lines.flush()
            self.tell(progress)
        self.start_what_can()

    def _forget(self) -> None:
        ended = [name for name, progress in self.progress.items() if progress.is_over]
        for name in ended[: max(len(ended) - KEPT, 0)]:
            del self.progress[name], self._entries[name]


def _nothing() -> None:
    pass
