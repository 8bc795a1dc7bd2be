"""Distributes the samples of watched axes to any number of watchers, each with its own signals and interval.

Watchers of an axis with the same interval share a grid in the core; what one asks for changes nothing for the
others, nor how often the core has to look. Samples are of moments, or the extremes of intervals: what swings
faster than samples come is not seen in the first, and has its true size in the second.
"""

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Protocol

from hil.core import WATCHES
from hil.core.fields import reader
from hil.vocab.time import NS_PER_S

MIN_INTERVAL_NS = 50_000
"""Minimum interval: three samples for each control step of a Mechaduino."""
MAX_INTERVAL_NS = 3600 * NS_PER_S
MAX_DENOMINATOR = 10**12
"""Maximum denominator of an interval that is no whole number of nanoseconds."""
MAX_GRIDS = WATCHES - 1
"""Maximum number of intervals of one axis; one is kept for runs, which all record at the same."""
MAX_SAMPLES_PER_S = 400_000
"""Maximum rate of all watchers of a bench in real time together, by simulated time: some tenths of a CPU."""
POINTS_OF_A_SAMPLE = 5
"""Times at which the core looks for extremes that cost about as much as one sample that is handed over."""
RING_SAMPLES = 8192
"""Samples in the core's ring for each grid: 1.2 s at the control rate. 3.3 MB."""
QUEUE_SAMPLES = 200_000
"""Samples in a watcher's queue; it loses the oldest when it does not take them."""

_AT_NS = reader("at_ns")

Interval = int | Fraction
"""Interval in nanoseconds; samples are at its multiples, rounded down to whole ones."""


class WatchedBench(Protocol):
    """Bench as a sampler needs it. Axes by address; ``slot``: which of the ``WATCHES`` of its axis."""

    def watch(self, axis: str, slot: int, interval_ns: Interval, capacity: int, points: int = 1) -> None: ...

    def table_names(self, axis: str, fields: Iterable[str]) -> Sequence[str]:
        """Names of fields in the core's table."""

    def take_samples(self, axis: str, slot: int) -> tuple[list[bytes], int]:
        """Samples since the last call, and the number lost since ``watch``."""


class Subscription:
    """Subscription of one watcher to one axis, by its address. ``signals``: by their names in the core's
    table; ``points`` above 1: samples are pairs, the extremes of so many looks in each interval."""

    def __init__(self, axis: str, signals: Iterable[str], interval_ns: Interval, points: int = 1) -> None:
        self.axis = axis
        self.interval_ns, self.points = interval_ns, points
        self.lost = 0
        self._queue: deque[bytes] = deque()
        self._readers = tuple(reader(name) for name in signals)

    def put(self, samples: list[bytes], lost: int) -> None:
        """Queue samples; ``lost`` were lost before them."""
        self.lost += lost
        self._queue.extend(samples)
        self.keep(QUEUE_SAMPLES)

    def keep(self, most: int) -> None:
        """Lose the oldest samples of more than so many."""
        for _ in range(len(self._queue) - most):
            self._queue.popleft()
            self.lost += 1

    @property
    def waiting(self) -> int:
        """Number of samples in the queue."""
        return len(self._queue)

    def drain(self, at_most: int | None = None) -> list[tuple[float, ...]]:
        """Rows of (at_ns, a value for each signal) since the last call."""
        rows = self.take_packed(at_most)
        return [(_AT_NS(row), *(read(row) for read in self._readers)) for row in rows]

    def take_packed(self, at_most: int | None = None) -> list[bytes]:
        """Whole snapshots in the binary layout, since the last call."""
        if at_most is None or at_most >= len(self._queue):
            taken = [*self._queue]
            self._queue.clear()
            return taken
        return [self._queue.popleft() for _ in range(at_most)]


@dataclass
class _Grid:
    """Interval at which an axis is watched."""

    slot: int
    interval_ns: Interval
    points: int
    lost: int = 0
    watchers: list[Subscription] = field(default_factory=list)

    @property
    def samples(self) -> int:
        """Number of samples in each interval."""
        return 1 if self.points == 1 else 2

    @property
    def per_s(self) -> Fraction:
        """Samples a second of all watchers, and what the core's looks cost, as samples."""
        looks = 0 if self.points == 1 else Fraction(self.points, POINTS_OF_A_SAMPLE)
        return (len(self.watchers) * self.samples + looks) * NS_PER_S / Fraction(self.interval_ns)


class Sampler:
    """Sampler of a bench: watches each axis at each interval that somebody wants."""

    def __init__(self, bench: WatchedBench, samples_per_s: int | None = None) -> None:
        """Limit all watchers together to ``samples_per_s``; None, in virtual time: no limit."""
        self._bench = bench
        self._samples_per_s = samples_per_s
        self._grids: dict[str, dict[tuple[Interval, int], _Grid]] = {}
        """Grids by axis, interval and points; each has a watcher."""

    def subscribe(
        self,
        axis: str,
        signals: tuple[str, ...],
        interval_ns: Interval,
        points: int = 1,
        *,
        is_limited: bool = True,
    ) -> Subscription:
        """Watch an axis from now on: a sample at every multiple of ``interval_ns``; with more ``points`` a
        pair of the extremes of each interval, of so many looks. A run's record is not limited by what others
        watch; there is one interval for all of those.

        Raises:
            ValueError: such an interval cannot be, or too much is watched already.
        """
        problem = interval_problem(interval_ns, points)
        if problem := problem or (self._excess(axis, interval_ns, points) if is_limited else None):
            raise ValueError(problem)
        grids, key = self._grids.get(axis, {}), (interval_ns, points)
        if key in grids:
            self._poll_grid(axis, grids[key])  # earlier samples belong to the other watchers
        else:
            taken = {grid.slot for grid in grids.values()}
            free = next(slot for slot in range(WATCHES) if slot not in taken)
            self._begin(axis, grid := _Grid(free, *key))
            self._grids.setdefault(axis, grids)[key] = grid
        subscription = Subscription(axis, self._bench.table_names(axis, signals), *key)
        grids[key].watchers.append(subscription)
        return subscription

    def _begin(self, axis: str, grid: _Grid) -> None:
        self._bench.watch(axis, grid.slot, grid.interval_ns, RING_SAMPLES, grid.points)

    def _excess(self, axis: str, interval_ns: Interval, points: int) -> str | None:
        """Reason why one more watcher would be too much, or None."""
        grids, key = self._grids.get(axis, {}), (interval_ns, points)
        if key not in grids and len(grids) >= MAX_GRIDS:
            known = ", ".join(str(each) for each, _ in sorted(grids))
            return f"{axis} is watched at {MAX_GRIDS} different intervals already; write one of {known} ns"
        if self._samples_per_s is None:
            return None
        there = [grid for of in self._grids.values() for grid in of.values()]
        one = _Grid(0, *key)
        rate = one.samples * NS_PER_S / Fraction(interval_ns) + sum(grid.per_s for grid in there)
        if key not in grids:
            rate += one.per_s  # of the looks
        if rate > self._samples_per_s:
            return (
                f"all watchers of a bench together get up to {self._samples_per_s:,} samples a second, and"
                " this would be more; write a longer interval, or end other watches"
            )
        return None

    def unsubscribe(self, subscription: Subscription) -> None:
        """End a subscription; what it has not taken stays there."""
        axis, key = subscription.axis, (subscription.interval_ns, subscription.points)
        grid = self._grids.get(axis, {}).get(key)
        if grid is None or subscription not in grid.watchers:
            return  # the axis has gone
        self._poll_grid(axis, grid)
        grid.watchers.remove(subscription)
        if grid.watchers:
            return
        self._bench.watch(axis, grid.slot, 0, 1)
        del self._grids[axis][key]
        if not self._grids[axis]:
            del self._grids[axis]

    def watched(self) -> list[str]:
        """Addresses of the axes that somebody watches."""
        return list(self._grids)

    def exchanged(self, axis: str) -> None:
        """Note that another axis has this address now."""
        for grid in self._grids.get(axis, {}).values():
            grid.lost = 0
            self._begin(axis, grid)

    def gone(self, axis: str) -> None:
        """Note that the axis is no more; its watchers get nothing further."""
        self._grids.pop(axis, None)

    def poll(self) -> None:
        """Fetch samples from the core; at least every ``period_ns`` of simulated time."""
        for axis in self._grids:
            self.poll_axis(axis)

    def poll_axis(self, axis: str) -> None:
        """Fetch the samples of one axis."""
        for grid in self._grids.get(axis, {}).values():
            self._poll_grid(axis, grid)

    def _poll_grid(self, axis: str, grid: _Grid) -> None:
        samples, lost = self._bench.take_samples(axis, grid.slot)
        new, grid.lost = lost - grid.lost, lost
        for subscription in grid.watchers:
            subscription.put(samples, new)

    @property
    def period_ns(self) -> int | None:
        """Time until a core's ring is half full; None: nobody watches."""
        between_ns = [
            Fraction(grid.interval_ns) / grid.samples for of in self._grids.values() for grid in of.values()
        ]
        return int(min(between_ns) * (RING_SAMPLES // 2)) if between_ns else None


def interval_problem(interval_ns: Interval, points: int = 1) -> str | None:
    """Reason why axes cannot be watched at an interval, or so often in each, or None."""
    if interval_ns.denominator > MAX_DENOMINATOR:
        return f"an interval of {interval_ns} ns; write a fraction with at most {MAX_DENOMINATOR} below"
    if interval_ns < MIN_INTERVAL_NS:
        return f"an interval of {str(interval_ns)[:40]} ns; write {MIN_INTERVAL_NS // 1000}us or more"
    if interval_ns > MAX_INTERVAL_NS:
        return f"an interval of {str(interval_ns)[:40]} ns; write at most {MAX_INTERVAL_NS}, an hour"
    most = int(interval_ns / MIN_INTERVAL_NS)
    if not 1 <= points <= most:
        return f"{points} points in {interval_ns} ns; write 1 to {most}: they are {MIN_INTERVAL_NS} ns apart"
    return None
