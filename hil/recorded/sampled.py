"""Samples of a recorded run's axes, over a window, at an interval."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from hil.core import WATCHES, CoreAxis
from hil.recorded.recorded_fields import RunField
from hil.recorded.recorded_run import RecordedRun
from hil.telemetry.sampler import Interval, interval_problem
from hil.vocab.time import NS_PER_S, SimTimeNs

SLICE_SAMPLES = 512
"""Samples of an axis in a chunk: they fit into a processor's cache."""
LONGEST_SLICE_NS = 10 * NS_PER_S
"""Maximum simulated time of one chunk: a reader has something soon."""


@dataclass(frozen=True)
class Chunk:
    """Samples of one axis in time's order. ``rows``: each (at_ns, one value for each field)."""

    axis: str
    fields: tuple[str, ...]
    rows: list[tuple[float, ...]]


def sampled(
    run: RecordedRun,
    fields: Sequence[RunField],
    from_ns: SimTimeNs,
    to_ns: SimTimeNs,
    interval_ns: Interval,
) -> Iterator[Chunk]:
    """Sample fields at the multiples of an interval from a time to another, both included; the run goes
    there. Chunks of all axes come slice by slice of simulated time.

    Raises:
        ValueError: there is no such interval.
    """
    if problem := interval_problem(interval_ns):
        raise ValueError(problem)
    run.run_until(SimTimeNs(max(from_ns - 1, 0)))  # a watch begins behind the time at which it is asked for
    of_axes: dict[str, list[str]] = {}
    for axis, name in fields:
        of_axes.setdefault(axis, []).append(name)
    watches = [_AxisWatch(run, axis, tuple(names), interval_ns) for axis, names in of_axes.items()]
    slice_ns = min(int(interval_ns * SLICE_SAMPLES), LONGEST_SLICE_NS)
    try:
        if run.now_ns == from_ns:
            yield from (watch.now() for watch in watches)
        while True:
            until_ns = SimTimeNs(min(run.now_ns + slice_ns, to_ns))
            # With an axis that ends its samples go.
            if run.now_ns < (reload_ns := run.next_reload_ns()) <= until_ns:
                run.run_until(SimTimeNs(max(reload_ns - 1, run.now_ns)))
                yield from [watch.chunk() for watch in watches]
                run.run_until(reload_ns)
                for watch in watches:
                    watch.exchanged()
            else:
                run.run_until(until_ns)
                yield from [watch.chunk() for watch in watches]
            if run.now_ns >= to_ns:
                break
    finally:
        for watch in watches:
            watch.end()


class _AxisWatch:
    """Watch of some fields of an axis, in a slot of its own. Raises ValueError: no slot is free."""

    def __init__(self, run: RecordedRun, axis: str, names: tuple[str, ...], interval_ns: Interval) -> None:
        self._run, self._axis, self._names = run, axis, names
        self._taken = run.taken_slots.setdefault(axis, set())
        free = (slot for slot in range(WATCHES) if slot not in self._taken)
        if (slot := next(free, None)) is None:
            raise ValueError(f"{axis} is watched at {WATCHES} intervals already")
        self._slot: int = slot
        self._interval_ns = interval_ns
        self._at: CoreAxis | None = None
        self._taken.add(slot)
        self.exchanged()

    def exchanged(self) -> None:
        """Watch the axis that is there now, if there is one: a reload may have exchanged it."""
        device_axis = self._run.runtime.parts.axes.get(self._axis)
        at = device_axis[0].axes[device_axis[1]] if device_axis else None
        if at is not self._at and at is not None:
            self._run.runtime.watch(self._axis, self._slot, self._interval_ns, 2 * SLICE_SAMPLES)
        self._at = at

    def now(self) -> Chunk:
        """State at the present."""
        if self._at is None:
            return Chunk(self._axis, self._names, [])
        snapshot = self._run.runtime.snapshot(self._axis)
        return Chunk(
            self._axis, self._names, [tuple(getattr(snapshot, name) for name in ("at_ns", *self._names))]
        )

    def chunk(self) -> Chunk:
        """Samples since the last chunk."""
        rows = self._at.take_rows(self._slot, ("at_ns", *self._names)) if self._at else []
        return Chunk(self._axis, self._names, rows)

    def end(self) -> None:
        if self._at:
            self._run.runtime.watch(self._axis, self._slot, 0, 1)
        self._taken.discard(self._slot)
