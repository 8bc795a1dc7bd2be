"""Health and metrics of a daemon, for those that watch it: words, problems, names, values; in no format."""

from collections.abc import Iterable, Sequence
from typing import Literal

from hil.vocab.late_dataclass import dataclass

OK, LATE, FAILED = "ok", "late", "failed"
STATES = {
    OK: "answers are right and in time",
    LATE: "all works; answers are right, and come late",
    FAILED: "something does not work",
}
"""States of a bench, and the meaning of each."""
EVENT_KINDS = {
    "verbs": "what was asked of a device, and of the bench's time",
    "typed": "what was typed at a board by a request, not by a client of its port",
    "faults": "faults that began, and ended",
    "motors": "motors that lost steps, at their times, and servos that push and stand",
    "runs": "runs that were submitted, began, ended",
    "refusals": "what was asked for and refused",
    "clients": "clients of ports, connections of doors, and leases, that came and went",
    "reloads": "reloads of the configuration",
    "lateness": "lateness that began, and ended",
    "trouble": "other problems of the bench's health that began, and ended",
    "log": "warnings and errors of the daemon's log that no other event tells, each behind its level",
}
"""Kinds of events, and what they are."""
LATE_KINDS = ("real_time", "wakes", "loop")
"""Kinds of problems that make a bench late; all others are failures."""


@dataclass(frozen=True)
class HealthProblem:
    """Problem of a bench. ``about`` is the device, port or segment, empty for the whole bench."""

    kind: str
    about: str
    what: str
    remedy: str


@dataclass(frozen=True)
class Metric:
    """A row of the table of metrics. The name follows Prometheus: ``hil_``, base units (seconds, bytes), and
    ``_total`` for a counter. ``labels`` are the names of what tells its values apart."""

    name: str
    kind: Literal["counter", "gauge", "histogram"]
    about: str
    labels: tuple[str, ...] = ()


@dataclass(frozen=True)
class Histogram:
    """Counts by upper bound. ``buckets``: ascending bounds in seconds, each with the number of values from
    the one before up to it; ``over``: number of values above them all; ``total_s``: sum of all."""

    buckets: Sequence[tuple[float, int]]
    over: int
    total_s: float


Value = float | Histogram
Reading = tuple[Metric, Iterable[tuple[tuple[str, ...], Value]]]
"""A metric, and its values by those of its labels; lazy: read while it is iterated."""
