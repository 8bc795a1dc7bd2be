"""Parting of two runs that should be one: the first state and the first bytes that differ."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

from hil.recorded.recorded_run import RecordedRun
from hil.recorded.run_events import place_of_sender
from hil.sim.twin import Twin
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs

STEPS_NS = (NS_PER_S, NS_PER_MS, 1000, 1)
"""Steps in which a difference is looked for, each within the one of the step before."""


class FieldDifference(NamedTuple):
    """Field of an axis that differs."""

    axis: str
    name: str
    then: float
    now: float


class HeardPiece(NamedTuple):
    """Bytes sent at a time."""

    at_ns: SimTimeNs
    data: bytes


class SentDifference(NamedTuple):
    """First bytes at a place that differ; None: nothing was sent."""

    place: str
    then: HeardPiece | None
    now: HeardPiece | None

    @property
    def at_ns(self) -> SimTimeNs:
        return min(piece.at_ns for piece in (self.then, self.now) if piece)


@dataclass
class RunsApart:
    """Differences of two runs. ``at_ns``: the first time at which a state differs, exact; ``fields``: those
    that differ then; ``sent``: by time."""

    at_ns: SimTimeNs | None = None
    fields: list[FieldDifference] = field(default_factory=list)
    sent: list[SentDifference] = field(default_factory=list)

    @property
    def first_ns(self) -> SimTimeNs | None:
        """Time at which the runs part; None: they are identical."""
        times_ns = [each.at_ns for each in self.sent]
        return min(times_ns if self.at_ns is None else [*times_ns, self.at_ns], default=None)


Make = Callable[[], RecordedRun]
"""Makes a run, at time 0."""


def parting(then: Make, now: Make, set_fields: Collection[tuple[str, str]] = ()) -> RunsApart:
    """Compare two runs up to the first one's end. ``set_fields``: fields, by axis and name, that differ of
    course."""
    pair = _Pair(then(), now(), set_fields)
    found, end_ns = RunsApart(), pair.then.end_ns
    at_ns = pair.first_difference(SimTimeNs(-1), end_ns, STEPS_NS[0])
    pair.run_until(end_ns)
    found.sent = sorted(pair.sent_differences(), key=lambda each: each.at_ns)
    for step_ns, finer_ns in pairwise(STEPS_NS):
        if at_ns is None:
            return found
        pair = _Pair(then(), now(), set_fields)
        before_ns = SimTimeNs(max(at_ns - step_ns, -1))
        at_ns = pair.first_difference(before_ns, at_ns, finer_ns)
    found.at_ns, found.fields = at_ns, pair.field_differences()
    return found


class _Pair:
    """Two runs side by side."""

    def __init__(self, then: RecordedRun, now: RecordedRun, set_fields: Collection[tuple[str, str]]) -> None:
        self.then, self.now = then, now
        self._set_fields = set_fields
        self._axes = [axis for axis in then.runtime.parts.axes if axis in now.runtime.parts.axes]
        self._sent = _pieces(then), _pieces(now)

    def run_until(self, until_ns: SimTimeNs) -> None:
        self.then.run_until(until_ns)
        self.now.run_until(until_ns)

    def first_difference(self, after_ns: SimTimeNs, end_ns: SimTimeNs, step_ns: int) -> SimTimeNs | None:
        """Go on in steps behind a time at which no state differs, to the first at which one does. -1: from
        the start, which may differ."""
        at_ns = SimTimeNs(max(after_ns, 0))
        self.run_until(at_ns)
        if after_ns < 0 and self.field_differences():
            return at_ns
        while at_ns < end_ns:
            at_ns = SimTimeNs(min(at_ns + step_ns, end_ns))
            self.run_until(at_ns)
            if self.field_differences():
                return at_ns
        return None

    def field_differences(self) -> list[FieldDifference]:
        """Fields that differ now."""
        found = []
        for axis in self._axes:
            one, other = self.then.runtime.snapshot(axis), self.now.runtime.snapshot(axis)
            if one.values == other.values:
                continue
            others = other.as_dict()
            found += [
                FieldDifference(axis, name, value, others[name])
                for name, value in one.as_dict().items()
                if name in others
                and repr(value) != repr(others[name])
                and (axis, name) not in self._set_fields
            ]
        return found

    def sent_differences(self) -> list[SentDifference]:
        """First difference at each place, so far."""
        then, now = self._sent
        found = []
        for place in {**then, **now}:
            one, other = then.get(place, []), now.get(place, [])
            same = next(
                (i for i, pair in enumerate(zip(one, other, strict=False)) if pair[0] != pair[1]),
                min(len(one), len(other)),
            )
            if same < max(len(one), len(other)):
                pieces = (pieces[same] if same < len(pieces) else None for pieces in (one, other))
                found.append(SentDifference(place, *pieces))
        return found


def _pieces(run: RecordedRun) -> dict[str, list[HeardPiece]]:
    pieces: dict[str, list[HeardPiece]] = {}

    def heard(device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        pieces.setdefault(place_of_sender(device, port), []).append(HeardPiece(at_ns, data))

    run.listeners.append(heard)
    return pieces
