"""Signals during long work: the process hears them however far simulated time has to go, and whatever is
asked of it."""

import gc
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

import pytest

from hil.testing import Bench
from hil.vocab.time import SimTimeNs
from hil.wire.step_dir import Edges

SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
CENTURY_S = 100 * 365 * 86_400.0
ROW_NS = 500_000_000_000
TRAIN = tuple(Edges(row * ROW_NS, steps=100_000_000, duration_ns=ROW_NS) for row in range(10))


class Heard(Exception):
    """Exception by which a test hears a signal."""


@contextmanager
def signal_soon() -> Iterator[Callable[[], float]]:
    """Raise ``Heard`` in half a second; return how long ago that was due.

    The garbage collector has no callbacks meanwhile: what is raised in one is lost, and pytest reports it as
    an error. Hypothesis leaves one behind in the process that this test may share with its tests. The signal
    comes again each second, so that one that is lost elsewhere costs a second.
    """

    def hear(number: int, frame: FrameType | None) -> None:
        raise Heard

    callbacks, gc.callbacks[:] = gc.callbacks[:], []
    before = signal.signal(signal.SIGALRM, hear)
    due_s = time.monotonic() + 0.5
    signal.setitimer(signal.ITIMER_REAL, 0.5, 1)
    try:
        yield lambda: time.monotonic() - due_s
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        gc.callbacks[:] = callbacks


def looped(bench: Bench) -> None:
    bench.run(ms=4500)
    bench.port("m1").write(b"xy")
    bench.run(ms=100)


def full(bench: Bench) -> None:
    looped(bench)
    bench.port("m2").write(b"xy")


def trained(bench: Bench) -> None:
    bench.run(ms=4500)
    bench.device("m1").drive(TRAIN)


def watched(bench: Bench) -> None:
    bench.run(ms=4500)
    bench.axis("m1").record(interval_ms=0.05)


def turning(bench: Bench) -> None:
    bench.run(ms=4500)
    bench.port("s1").write(b"m2000000000\r")
    bench.run(ms=500)
    assert bench.axis("s1").snapshot().motion_state


@pytest.mark.parametrize("busy", [looped, full, trained, watched, turning])
def test_a_century_can_be_broken_off(busy: Callable[[Bench], None]) -> None:
    bench = Bench(
        {
            "bench": "t",
            "devices": {"m1": SERVO, "m2": {**SERVO, "plant": "full"}, "s1": {"profile": "sac"}},
        }
    )
    busy(bench)
    with signal_soon() as late_s, pytest.raises(Heard):
        bench.run(ms=CENTURY_S * 1000)
    assert late_s() < 2, "a call of the core takes some milliseconds"
    bench.run(ms=1)


def test_a_group_that_cannot_keep_up_has_its_turn_and_others_theirs() -> None:
    bench = Bench({"bench": "t", "devices": {"m1": SERVO}})
    trained(bench)
    group = bench._runtime.parts.group_of("m1")
    begin_ns, asked = group.now_ns, 0

    def is_over() -> bool:
        nonlocal asked
        asked += 1
        return asked == 3

    group.advance(SimTimeNs(begin_ns + 10**15), is_over)
    assert asked == 3
    assert begin_ns + 10**8 < group.now_ns < begin_ns + 10**11
