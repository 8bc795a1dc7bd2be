"""The same inputs to a bench with something changed: where the runs part, and both as series."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from hil.core.fields import described
from hil.recorded.log_changes import ChangeRefused, LogChanges, changed
from hil.recorded.parting import RunsApart, parting
from hil.recorded.recorded_fields import RunField
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.sampled import sampled
from hil.sim.input_log import InputLog
from hil.telemetry.recording import Recording
from hil.vocab.time import SimTimeNs

THEN, NOW, DIFFERENCE = "then", "now", "difference"
"""Names of the series of a comparison."""


@dataclass
class RunSeries(Recording):
    """Series of fields of a run. ``signals``: with their axes, as in ``m1.e``; each has a panel."""

    def unit(self, signal: str) -> str:
        return described(signal.rpartition(".")[2]).unit

    def panels(self) -> list[list[str]]:
        return [[signal] for signal in self.signals]

    def at_s(self, origin_ns: float | None = None) -> list[float]:
        """Times in seconds of the run."""
        return super().at_s(origin_ns or 0)


@dataclass
class WhatIf:
    """Changed run beside the run as it was. ``left_out``: inputs that the changed bench cannot take, by
    their number in the log, and why."""

    log: InputLog
    changes: LogChanges
    left_out: dict[int, str] = field(default_factory=dict)

    def then(self) -> RecordedRun:
        """Make the run as it was, at time 0."""
        return RecordedRun(self.log)

    def now(self) -> RecordedRun:
        """Make the changed run, at time 0.

        Raises:
            ChangeRefused: what was added cannot be taken by the bench.
        """
        return RecordedRun(self.changes.log, self._on_problem)

    def _on_problem(self, index: int, problem: str) -> None:
        if any(self.changes.log.inputs[index] is each for each in self.changes.own):
            raise ChangeRefused(problem)
        self.left_out[index] = problem

    def parting(self) -> RunsApart:
        """Compare the runs."""
        return parting(self.then, self.now, self.changes.fields)

    def series(
        self, fields: Sequence[RunField], from_ns: SimTimeNs, to_ns: SimTimeNs, interval_ns: int
    ) -> dict[str, RunSeries]:
        """Sample both runs: then, now, and the difference."""
        then = _series(self.then(), fields, from_ns, to_ns, interval_ns)
        now = _series(self.now(), fields, from_ns, to_ns, interval_ns)
        difference = RunSeries(
            then.signals, [_minus(*rows) for rows in zip(now.rows, then.rows, strict=True)]
        )
        return {THEN: then, NOW: now, DIFFERENCE: difference}


def changed_run(
    run: RecordedRun,
    settings: Sequence[str] = (),
    faults: Sequence[str] = (),
    without: Sequence[str] = (),
    at_ns: SimTimeNs | None = None,
) -> WhatIf:
    """Change a recorded run, as ``hil.recorded.log_changes.changed``.

    Raises:
        ChangeRefused: a change names nothing, or its value cannot be.
    """
    return WhatIf(run.log, changed(run, settings, faults, without, at_ns))


def _minus(one: tuple[float, ...], other: tuple[float, ...]) -> tuple[float, ...]:
    return (one[0], *(a - b for a, b in zip(one[1:], other[1:], strict=True)))


def _series(
    run: RecordedRun, fields: Sequence[RunField], from_ns: SimTimeNs, to_ns: SimTimeNs, interval_ns: int
) -> RunSeries:
    columns: dict[RunField, list[float]] = {each: [] for each in fields}
    times_ns: list[float] = []
    for chunk in sampled(run, fields, from_ns, to_ns, interval_ns):
        for number, name in enumerate(chunk.fields, start=1):
            columns[RunField(chunk.axis, name)] += [row[number] for row in chunk.rows]
        if chunk.axis == fields[0].axis:
            times_ns += [row[0] for row in chunk.rows]
    return RunSeries(tuple(map(str, fields)), [*zip(times_ns, *columns.values(), strict=True)])


def told_fields(run: RecordedRun, found: RunsApart) -> Iterator[RunField]:
    """Fields that show how the runs part: the error and the angle, or the usual ones, of axes that differ."""
    for axis in dict.fromkeys(each.axis for each in found.fields):
        device, part = run.runtime.parts.axes[axis]
        kind = device.axes[part].kind
        names = [name for name in ("e", "position_deg") if name in kind.fields]
        yield from (RunField(axis, name) for name in names or kind.default_signals[:2])
