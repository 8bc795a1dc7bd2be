"""Multi-axis runs on a bench in memory, to their ends in simulated time."""

from collections.abc import Callable, Mapping

from hil.runs import (
    Execution,
    Progress,
    RunTextError,
    Soon,
    TwinAxes,
    all_problems,
    parse_run,
    plan_run,
    run_from_data,
)
from hil.sim.bench import BenchRuntime
from hil.telemetry import Sampler
from hil.vocab.axis import AxisNow
from hil.vocab.time import SimTimeNs

RUN_LEAD_NS = 1_000_000
"""Time between a run's phrases: in virtual time nothing needs longer."""


class KitRuns:
    """Runs on the axes of a bench, whose time ``run_until`` lets pass."""

    def __init__(
        self, runtime: BenchRuntime, sampler: Sampler, run_until: Callable[[SimTimeNs], None]
    ) -> None:
        self._axes, self._run_until = TwinAxes(runtime, sampler), run_until

    @property
    def axes(self) -> Mapping[str, AxisNow]:
        """Axes as a run would begin with them now."""
        return self._axes.axes()

    def execute(self, run: Mapping[str, object] | str) -> Execution:
        """Check and plan a run now. Raises ConfigError: it cannot be done, with all problems."""
        axes = self.axes
        if isinstance(run, str) and run.strip() and "\n" not in run and ":" not in run:
            what = f"a run's text or a dict is wanted, not the name of a file, {run!r}"
            raise TypeError(f"{what}; write Path({run!r}).read_text()")
        try:
            document = parse_run(run, "<run>") if isinstance(run, str) else run_from_data(run)
        except RunTextError as error:
            raise all_problems(error, axes) from None
        return Execution(plan_run(*document, axes), self._axes, Soon(self._axes, RUN_LEAD_NS))

    def perform(self, run: Mapping[str, object] | str | Execution) -> Progress:
        """Carry out a run to its end. Raises ConfigError: as ``execute``."""
        execution = run if isinstance(run, Execution) else self.execute(run)
        for until_ns in execution.run():
            self._run_until(SimTimeNs(until_ns))
        return execution.progress
