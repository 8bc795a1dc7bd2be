"""Carries out accepted runs: plans each from where its axes are, and follows it to its end."""

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from hil.config import ConfigError
from hil.live.configured import Configured
from hil.live.runs.lead import Together
from hil.live.runs.planning import Planning
from hil.runs import Execution, Plan, Progress, Soon
from hil.vocab.axis import Axes
from hil.vocab.bridge_protocol import BenchGone
from hil.vocab.desk_protocol import Source
from hil.vocab.verbs import VerbRefused

LEAD_WALL_NS = 20_000_000
"""Time between the giving of a phrase and its start: 32 axes are given theirs in a tenth of it."""
PACE_WALL_NS = 20_000_000
"""Further time before a change of pace, for the making of its paths."""
TELL_S = 0.1
"""Time between two reports on a run whose state and step are as they were."""


class NotBegun(Exception):
    """Error of an accepted run that cannot begin: ``str(error)`` says why."""


@dataclass
class QueuedRun:
    """Accepted run that has not ended. ``names``: devices here, by their names in the run;
    ``ends_deg``: where it leaves them. Of the document only the text is kept: read, a long one takes forty
    times the room."""

    text: str
    file: str
    source: Source
    names: Mapping[str, str]
    ends_deg: Mapping[str, float]
    progress: Progress
    is_shared: bool = False
    """True if other benches take part."""
    planned: tuple[Plan, Together | None] | None = None
    """Plan that was made at its submission, if it begins at once: nothing has moved since."""
    execution: Execution | None = None
    """Execution, once the run has begun."""
    task: asyncio.Task[None] | None = None

    @property
    def name(self) -> str:
        return self.progress.run

    @property
    def devices(self) -> set[str]:
        return set(self.names.values())


class CarryingOut:
    """Moves the axes of one bench. ``tell``: called at changes of a run, ten times a second in motion."""

    def __init__(
        self, axes: Axes, planning: Planning, configured: Configured, tell: Callable[[Progress], None]
    ) -> None:
        self._axes = axes
        self._planning = planning
        self._configured = configured
        self._tell = tell
        self._releasing: set[asyncio.Task[None]] = set()

    async def run(self, entry: QueuedRun) -> None:
        """Carry out one run, from its plan to its end. Raises NotBegun: nothing has moved."""
        if entry.is_shared:
            await self._lead(entry)
            return
        try:
            plan, _ = await self._planning.plan_now(entry.source, entry.text, entry.file, entry.name)
        except (ConfigError, VerbRefused) as error:
            raise NotBegun(f"it cannot be done any more: {error}") from None
        lead_ns = round(LEAD_WALL_NS * self._configured.config.speed)
        baton = Soon(self._axes, max([lead_ns, *(self._axes[device].lead_ns for device in entry.devices)]))
        execution = Execution(plan, self._axes, baton, entry.names, entry.progress)
        execution.lead_ns = lead_ns + round(PACE_WALL_NS * self._configured.config.speed)
        await self.follow(entry, execution)

    async def _lead(self, entry: QueuedRun) -> None:
        """Carry out a run that spans benches."""
        together: Together | None = None
        try:
            planned, entry.planned = entry.planned, None
            if planned is None:
                planned = await self._planning.plan_now(entry.source, entry.text, entry.file, entry.name)
            plan, together = planned
            assert together is not None
            self._planning.check_still(plan)
            together.name = entry.name
            await together.join(entry.text, plan)
        except (ConfigError, VerbRefused, BenchGone) as error:
            if together:
                await together.release()
            raise NotBegun(f"it did not begin: {error}") from None
        except asyncio.CancelledError:
            if together:
                # In a task of its own: this one is cancelled, and the others still hold their axes.
                releasing = asyncio.get_running_loop().create_task(together.release())
                self._releasing.add(releasing)
                releasing.add_done_callback(self._releasing.discard)
            raise
        execution = Execution(plan.part(entry.names), self._axes, together.baton, entry.names)
        together.begin(execution, entry.progress)
        try:
            await self.follow(entry, execution, together.each)
            await together.finish()
        finally:
            together.leave()

    async def follow(
        self, entry: QueuedRun, execution: Execution, each: Callable[[], None] = lambda: None
    ) -> None:
        """Follow an execution until nothing is left to do; ``each`` is called at every look at it."""
        entry.execution = execution
        speed, loop = self._configured.config.speed, asyncio.get_running_loop()
        told, told_s = ("", -1), loop.time()
        for until_ns in execution.run():
            each()
            progress = entry.progress
            if (progress.state, progress.step) != told or loop.time() - told_s >= TELL_S:
                told, told_s = (progress.state, progress.step), loop.time()
                self._tell(progress)
            await asyncio.sleep(max((until_ns - self._axes.now_ns) / 1e9 / speed, 0.0))
