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


def test_extremes_are_those_of_what_was_seen() -> None:
    bench, sampler = bench_of("m1")
    bench.parts.axis("m1").set("load_torque_Nm", 0.4)  # it swings
    points = 12
    interval_ns = Fraction(NS_PER_S, 60)
    pairs = sampler.subscribe("m1", ("position_deg", "current_a_A"), interval_ns, points)
    every = sampler.subscribe("m1", ("position_deg", "current_a_A"), interval_ns / points)
    bench.advance(SimTimeNs(NS_PER_S // 2))
    sampler.poll()
    seen, told = every.drain(), pairs.drain()
    assert len(seen) == 30 * points
    assert len(told) == 2 * 30
    for number in range(30):
        interval = seen[number * points : (number + 1) * points]
        first, last = told[2 * number : 2 * number + 2]
        assert (first[0], last[0]) == (interval[0][0], interval[-1][0])
        for column in (1, 2):
            values = [row[column] for row in interval]
            assert sorted((first[column], last[column])) == [min(values), max(values)]
            if first[column] != last[column]:
                assert values.index(first[column]) < values.index(last[column])


def test_extremes_and_samples_of_an_interval_stand_beside_each_other() -> None:
    bench, sampler = bench_of("m1")
    samples = sampler.subscribe("m1", (), 10**6)
    pairs = sampler.subscribe("m1", (), 10**6, 4)
    assert sampler.period_ns == 4096 * 500_000
    bench.advance(SimTimeNs(10**7))
    assert times_of(sampler, samples) == grid(10**6, 0, 10**7)
    assert len(pairs.drain()) == 20
    sampler.unsubscribe(samples)
    bench.advance(SimTimeNs(2 * 10**7))
    assert len(times_of(sampler, pairs)) == 20
    sampler.unsubscribe(pairs)
    assert sampler.period_ns is None


@pytest.mark.parametrize("points", [0, -1, 21, 10**9])
def test_looks_are_apart(points: int) -> None:
    _, sampler = bench_of("m1")
    with pytest.raises(
        ValueError, match=f"{points} points in 1000000 ns; write 1 to 20: they are 50000 ns apart"
    ):
        sampler.subscribe("m1", (), 10**6, points)


def test_looks_for_extremes_count() -> None:
    bench, _ = bench_of("m1", "m2")
    sampler = Sampler(bench, 1000)
    sampler.subscribe("m1", (), 10**7, 20)  # 200 samples a second, 2000 looks
    sampler.subscribe("m1", (), 10**7, 20)  # and 200 more of the same looks
    with pytest.raises(ValueError, match="1,000 samples a second"):
        sampler.subscribe("m2", (), 10**7, 20)


@pytest.mark.parametrize(
    ("interval_ns", "why"),
    [
        (0, "write 50us or more"),
        (-(10**30), "write 50us or more"),
        (MIN_INTERVAL_NS - 1, "write 50us or more"),
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
