"""Watchers of an axis: each on the grid that it asked for, whatever others ask, and not without limit."""

from collections.abc import Sequence
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.compose import bench_runtime, find_catalogue
from hil.compose.replay import MemoryOptions
from hil.config import from_dict
from hil.sim.bench import BenchRuntime
from hil.telemetry import Sampler, Subscription
from hil.telemetry.sampler import (
    MAX_DENOMINATOR,
    MAX_GRIDS,
    MAX_INTERVAL_NS,
    MAX_SAMPLES_PER_S,
    MIN_INTERVAL_NS,
)
from hil.testing.memory_store import MemoryStore
from hil.vocab.time import NS_PER_S, SimTimeNs

SERVO = {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}


def bench_of(*names: str) -> tuple[BenchRuntime, Sampler]:
    catalogue = find_catalogue({"memory": MemoryOptions})
    config = from_dict({"bench": "t", "devices": {name: SERVO for name in names}}, catalogue)
    runtime = bench_runtime(config, catalogue, {}, MemoryStore())
    return runtime, Sampler(runtime)


def times_of(sampler: Sampler, subscription: Subscription) -> list[float]:
    sampler.poll()
    return [row[0] for row in subscription.drain()]


def grid(interval_ns: int | Fraction, after_ns: int, until_ns: int) -> list[int]:
    """Grid of an interval by the definition: floor(k * interval)."""
    first, last = int(after_ns / Fraction(interval_ns)), int((until_ns + 1) / Fraction(interval_ns))
    every = [int(k * interval_ns) for k in range(first, last + 1)]
    return [at_ns for at_ns in every if after_ns < at_ns <= until_ns]


def test_a_millisecond_beside_almost_a_millisecond() -> None:
    bench, sampler = bench_of("m1")
    intervals = (1_000_000, 1_000_001)  # their greatest common divisor is 1 ns
    watchers = [sampler.subscribe("m1", ("r",), each) for each in intervals]
    bench.advance(SimTimeNs(2 * NS_PER_S))
    for watcher, interval_ns in zip(watchers, intervals, strict=True):
        assert times_of(sampler, watcher) == grid(interval_ns, 0, 2 * NS_PER_S)
        assert watcher.lost == 0
    assert sampler.period_ns == 4096 * 1_000_000


INTERVALS = st.integers(MIN_INTERVAL_NS, 10**9) | st.fractions(MIN_INTERVAL_NS, 10**9, max_denominator=1000)


@settings(max_examples=30)
@given(st.lists(st.tuples(INTERVALS, st.integers(0, 10**8)), min_size=1, max_size=6))
def test_any_watchers_are_each_on_their_grid(asked: Sequence[tuple[int | Fraction, int]]) -> None:
    bench, sampler = bench_of("m1")
    watchers = []
    for interval_ns, wait_ns in asked:
        bench.advance(SimTimeNs(bench.now_ns + wait_ns))
        watchers.append((sampler.subscribe("m1", (), interval_ns), interval_ns, bench.now_ns))
    bench.advance(SimTimeNs(bench.now_ns + 10**8))
    for watcher, interval_ns, since_ns in watchers:
        assert times_of(sampler, watcher) == grid(interval_ns, since_ns, bench.now_ns)


def test_who_goes_takes_nothing_from_the_others() -> None:
    bench, sampler = bench_of("m1")
    stays, goes = sampler.subscribe("m1", (), 10**6), sampler.subscribe("m1", (), 10**6)
    other = sampler.subscribe("m1", (), 10**6 + 1)
    bench.advance(SimTimeNs(10**7))
    sampler.unsubscribe(goes)
    sampler.unsubscribe(other)
    bench.advance(SimTimeNs(2 * 10**7))
    late = sampler.subscribe("m1", (), 10**6)
    bench.advance(SimTimeNs(3 * 10**7))
    assert times_of(sampler, stays) == grid(10**6, 0, 3 * 10**7)
    assert times_of(sampler, goes) == grid(10**6, 0, 10**7)
    assert times_of(sampler, late) == grid(10**6, 2 * 10**7, 3 * 10**7)
    sampler.unsubscribe(stays)
    sampler.unsubscribe(late)
    assert sampler.period_ns is None


@pytest.mark.parametrize(
    ("interval_ns", "why"),
    [
        (0, "write 50000 or more"),
        (-(10**30), "write 50000 or more"),
        (MIN_INTERVAL_NS - 1, "write 50000 or more"),
        (MAX_INTERVAL_NS + 1, "write at most 3600000000000, an hour"),
        (1 << 63, "write at most 3600000000000, an hour"),
        (10**400, "write at most 3600000000000, an hour"),
        (Fraction(10**9 * (MAX_DENOMINATOR + 1) + 1, MAX_DENOMINATOR + 1), "write a fraction"),
    ],
)
def test_what_is_refused_leaves_nothing_behind(interval_ns: int | Fraction, why: str) -> None:
    bench, sampler = bench_of("m1")
    with pytest.raises(ValueError, match=why):
        sampler.subscribe("m1", (), interval_ns)
    assert sampler.period_ns is None
    watcher = sampler.subscribe("m1", (), MAX_INTERVAL_NS)
    sampler.unsubscribe(watcher)
    watcher = sampler.subscribe("m1", (), 10**6)
    bench.advance(SimTimeNs(10**7))
    assert times_of(sampler, watcher) == grid(10**6, 0, 10**7)


def test_an_axis_has_so_many_grids_and_one_for_runs() -> None:
    bench, sampler = bench_of("m1", "m2")
    watchers = [sampler.subscribe("m1", (), 10**7 + i) for i in range(MAX_GRIDS)]
    with pytest.raises(ValueError, match=r"m1 is watched at 16 different intervals already; write one of"):
        sampler.subscribe("m1", (), 10**6)
    shared = sampler.subscribe("m1", (), 10**7)
    other = sampler.subscribe("m2", (), 10**6)
    run = sampler.subscribe("m1", (), 10**6, is_limited=False)
    bench.advance(SimTimeNs(10**8))
    assert times_of(sampler, run) == times_of(sampler, other) == grid(10**6, 0, 10**8)
    assert times_of(sampler, shared) == grid(10**7, 0, 10**8)
    sampler.unsubscribe(run)
    sampler.unsubscribe(watchers[3])
    sampler.subscribe("m1", (), 10**6)


def test_all_watchers_together_get_only_so_much() -> None:
    bench, _ = bench_of("m1", "m2")
    sampler = Sampler(bench, MAX_SAMPLES_PER_S)
    per_watcher = NS_PER_S // MIN_INTERVAL_NS
    watchers = [
        sampler.subscribe(name, (), MIN_INTERVAL_NS)
        for name in ("m1", "m2")
        for _ in range(MAX_SAMPLES_PER_S // per_watcher // 2)
    ]
    for name in ("m1", "m2"):
        with pytest.raises(ValueError, match="400,000 samples a second, and this would be more; write"):
            sampler.subscribe(name, (), MAX_INTERVAL_NS)
    sampler.unsubscribe(watchers[0])
    sampler.subscribe("m2", (), 10**9)
