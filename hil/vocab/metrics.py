"""Metrics of a daemon, for those that watch it: names, kinds and values, in no format."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal


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
