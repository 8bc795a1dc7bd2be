"""Plans runs from where the bench's axes are, or will be."""

from collections.abc import Callable, Mapping

from hil.config.document import Document
from hil.live.configured import Configured
from hil.live.core_thread import WallClock
from hil.live.off_loop import off_loop
from hil.live.runs.axis_names import device_names, other_benches, taken_twice
from hil.live.runs.lead import Together
from hil.live.runs.other_benches import OtherBenches
from hil.runs import Plan, RunDocument, RunTextError, all_problems, parse_run, plan_run
from hil.vocab.axis import Axes, AxisNow
from hil.vocab.desk_protocol import Source
from hil.vocab.problem import ConfigError
from hil.vocab.verbs import VerbRefused

FoundAxes = Callable[[], Mapping[str, AxisNow]]
"""Answers where a bench's axes are, or will be."""


class Planning:
    """Reads and plans runs of this bench, and those it leads over ``others``."""

    def __init__(self, axes: Axes, configured: Configured, wall: WallClock, others: OtherBenches) -> None:
        self._axes = axes
        self._configured = configured
        self._wall = wall
        self._others = others

    def read(self, text: str, file: str, name: str = "") -> tuple[RunDocument, Document]:
        """Read a run's text; ``name`` stands in the place of its own. Raises ConfigError: the text is no run,
        or has an axis twice."""
        run, document = parse_run(text, file)
        run = run.model_copy(update={"run": name}) if name else run
        if findings := taken_twice(run, self._configured.config.bench):
            raise RunTextError(document, findings, run)
        return run, document

    def read_all(self, text: str, file: str, name: str, axes: FoundAxes) -> tuple[RunDocument, Document]:
        """Read a short run's text as ``read``; an error has all problems that the axes would make, too."""
        try:
            return self.read(text, file, name)
        except RunTextError as error:
            raise self._with_the_rest(error, axes()) from None

    def _with_the_rest(self, error: RunTextError, axes: Mapping[str, AxisNow]) -> ConfigError:
        """Problems of a text, with those of the rest of the run, where that is of this bench alone."""
        if error.rest is None or self.is_shared(error.rest):
            return error
        return all_problems(error, self._as_named(error.rest, axes))

    def names(self, run: RunDocument) -> dict[str, str]:
        """Devices of this bench that take part, by their names in the run."""
        return device_names(run, self._configured.config.bench)

    def is_shared(self, run: RunDocument) -> bool:
        """True if other benches take part."""
        return bool(other_benches(run, self._configured.config.bench))

    def plan(self, run: RunDocument, document: Document, axes: Mapping[str, AxisNow]) -> Plan:
        """Plan a short run of this bench alone; ``axes``: where its devices are.

        Raises:
            ConfigError: it cannot be done.
        """
        return plan_run(run, document, self._as_named(run, axes))

    async def plan_text(
        self, source: Source, text: str, file: str, axes: FoundAxes, name: str = ""
    ) -> tuple[Plan, Together | None]:
        """Plan any run, in a thread if it is long; answers with the plan who leads it if it spans benches,
        and has looked at them. Raises ConfigError: it cannot be done."""
        try:
            run, document = await off_loop(text, self.read, text, file, name)
        except RunTextError as error:
            raise self._with_the_rest(error, axes()) from None
        together = None
        others: dict[str, AxisNow] = {}
        if self.is_shared(run):
            together = Together(self._configured, self._wall, self._others, source, run)
            others = await together.look(document)
        now = self._as_named(run, axes()) | others
        return await off_loop(text, plan_run, run, document, now), together

    async def plan_now(self, source: Source, text: str, file: str, name: str) -> tuple[Plan, Together | None]:
        """Plan as ``plan_text``, from where the axes are when the plan is made.

        Raises:
            ConfigError: it cannot be done.
            VerbRefused: an axis was moved meanwhile.
        """
        planned = await self.plan_text(source, text, file, self._axes.axes, name)
        self.check_still(planned[0])
        return planned

    def check_still(self, plan: Plan) -> None:
        """Check that this bench's axes are as they were planned. Raises VerbRefused: one was moved
        meanwhile."""
        axes = self._axes.axes()
        for name, device in self.names(plan.run).items():
            if why := axes[device].why_not:
                raise VerbRefused("not_now", f"{name}: {why}; {axes[device].remedy}")
            if axes[device].position_deg != plan.axes[name].position_deg:
                raise VerbRefused("not_now", f"{name} was moved while the run was planned")

    def _as_named(self, run: RunDocument, axes: Mapping[str, AxisNow]) -> dict[str, AxisNow]:
        """Rename the axes as the run does; axes that it names wrongly are looked for among all."""
        return dict(axes) | {name: axes[device] for name, device in self.names(run).items() if device in axes}
