"""Runs in the daemon: which are accepted, which wait, which move, and what became of them.

The rule: a run is checked as a whole when it is submitted, from where its axes will be after the runs before
it. It starts when none of its axes is in a run that was accepted earlier and has not ended, so runs of other
axes go on beside it; it is then planned anew from where the axes are. At most ``WAITING`` runs wait, later
ones are refused. The same name submitted again is the same run: its state is answered, nothing is done twice.
"""

import asyncio
import json
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hil.config import ConfigError
from hil.config.document import Document
from hil.runs import BenchAxes, Execution, Progress, RunDocument, parse_run, plan_run
from hil.runs.document import DOCUMENT_BYTES
from hil.runs.execute import How
from hil.vocab.bridges import Source
from hil.vocab.verbs import Role, VerbRefused

if TYPE_CHECKING:
    from hil.daemon.daemon import Daemon

WAITING = 1000
KEPT = 1000
"""Of runs that have ended; older ones are forgotten."""
LEAD_WALL_NS = 20_000_000
"""Between the giving of a phrase and its start: 32 axes are given theirs in a tenth of it."""
TELL_S = 0.1


class Runs:
    """Of one daemon."""

    def __init__(self, daemon: "Daemon") -> None:
        self._daemon = daemon
        self._axes = BenchAxes(daemon.bench, daemon.watches.sampler)
        self._documents: dict[str, tuple[RunDocument, Document]] = {}
        self._executions: dict[str, Execution] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._ends_deg: dict[str, Mapping[str, float]] = {}
        self.progress: dict[str, Progress] = {}
        """Of all runs that are remembered, by name, in the order of their submission."""
        self.listeners: list[Callable[[Progress], None]] = []
        """Called when a run's state changes, and ten times a second while it moves."""

    def submit(self, source: Source, text: str, file: str = "<run>") -> Progress:
        """Accept a run, or tell how the one of this name does.

        Raises:
            ConfigError: it cannot be done, with all problems.
            VerbRefused: not by this source, or not now.
        """
        if source.role < Role.OPERATOR:
            raise VerbRefused("forbidden", "a run needs the role operator")
        if len(text) > DOCUMENT_BYTES:
            raise VerbRefused("bad_request", f"{len(text)} characters; a run has at most {DOCUMENT_BYTES}")
        run, document = parse_run(text, file)
        if run.run in self.progress:
            return self.progress[run.run]
        if sum(progress.state == "queued" for progress in self.progress.values()) >= WAITING:
            raise VerbRefused("not_now", f"{WAITING} runs wait already; submit it again later")
        plan = plan_run(run, document, self._expected(run))
        self._documents[run.run] = (run, document)
        self._ends_deg[run.run] = plan.ends_deg
        self.progress[run.run] = progress = Progress(run.run, steps=plan.steps)
        self._forget()
        self._start_what_can()
        return self.progress.get(run.run, progress)

    def check(self, text: str, file: str) -> dict[str, Any]:
        """Whether it can be done, without doing it.

        Raises:
            ConfigError: it cannot, with all problems.
        """
        run, document = parse_run(text, file)
        return {"run": run.run, "steps": plan_run(run, document, self._expected(run)).steps}

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
        if progress.state == "queued" and name not in self._executions:
            progress.state, progress.why = "cancelled", "it was cancelled before it began"
            self._tell(progress)
            self._start_what_can()
        elif name in self._executions:
            self._executions[name].cancel = how
        return progress

    def using(self, devices: Collection[str]) -> dict[str, str]:
        """Runs that have not ended, by those of these devices that are in them."""
        waiting = [name for name, p in self.progress.items() if p.state in ("queued", "running")]
        return {axis: name for name in waiting for axis in self._documents[name][0].axes if axis in devices}

    async def close(self) -> None:
        """The bench ends, and with it what moves."""
        for task in list(self._tasks.values()):
            task.cancel()
        await asyncio.gather(*self._tasks.values(), return_exceptions=True)

    def _expected(self, run: RunDocument) -> dict[str, Any]:
        """The axes as they will be when the runs before this one have ended."""
        axes = self._axes.axes()
        for name, before in self.progress.items():
            if before.state not in ("queued", "running"):
                continue
            for axis, position_deg in self._ends_deg[name].items():
                axes[axis] = replace(axes[axis], position_deg=position_deg, why_not=None)
        return axes

    def _start_what_can(self) -> None:
        taken: set[str] = set()
        for name, progress in list(self.progress.items()):
            if progress.state not in ("queued", "running"):
                continue
            run, document = self._documents[name]
            if progress.state == "queued" and name not in self._tasks and not taken & set(run.axes):
                self._start(name, run, document)
            if self.progress[name].state in ("queued", "running"):
                taken |= set(run.axes)

    def _start(self, name: str, run: RunDocument, document: Document) -> None:
        progress = self.progress[name]
        try:
            plan = plan_run(run, document, self._axes.axes())
        except ConfigError as error:
            progress.state, progress.why = "failed", f"it cannot be done any more: {error}"
            progress.ended_at_ns = self._daemon.bench.now_ns
            self._tell(progress)
            return
        lead_ns = round(LEAD_WALL_NS * self._daemon.config.speed)
        execution = self._executions[name] = Execution(plan, self._axes, lead_ns)
        self.progress[name] = execution.progress
        self._tasks[name] = asyncio.get_running_loop().create_task(self._carry_out(name, execution))

    async def _carry_out(self, name: str, execution: Execution) -> None:
        bench, speed = self._daemon.bench, self._daemon.config.speed
        told = ""
        try:
            for until_ns in execution.run():
                self._daemon.lines.flush()
                if (state := json.dumps(execution.progress.as_dict())) != told:
                    told = state
                    self._tell(execution.progress)
                await asyncio.sleep(max((until_ns - bench.now_ns) / 1e9 / speed, 0.0))
        finally:
            del self._executions[name], self._tasks[name]
            self._daemon.lines.flush()
            self._tell(execution.progress)
        self._start_what_can()

    def _tell(self, progress: Progress) -> None:
        for listener in self.listeners:
            listener(progress)

    def _forget(self) -> None:
        ended = [name for name, p in self.progress.items() if p.state not in ("queued", "running")]
        for name in ended[: max(len(ended) - KEPT, 0)]:
            for table in (self.progress, self._documents, self._ends_deg):
                table.pop(name, None)
