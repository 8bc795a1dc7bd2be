"""Benches that choose CPUs beside each other: names in a space of this test's own."""

import os
import select
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from hil.host import cpu_claim
from hil.host.cpu_claim import CpuClaim, Holder, by_cpu, claim_cpu, holders, holders_in, least_held
from hil.host.real_time import Grant

CLAIMS = """
import sys
from hil.host import cpu_claim
cpu_claim._PREFIX = sys.argv[1]
claim = cpu_claim.claim_cpu(None, sys.argv[2])
print(claim.cpu, flush=True)
sys.stdin.read()
"""
LISTED = """Num       RefCount Protocol Flags    Type St Inode Path
0000000000000000: 00000002 00000000 00000000 0002 01 58133 @hil-cpu/1/mill/77.0
0000000000000000: 00000002 00000000 00010000 0001 01  3071 /run/user/1000/hil/mill/control.sock
0000000000000000: 00000002 00000000 00000000 0002 01 58139 @hil-cpu/3/lathe/78.12
0000000000000000: 00000002 00000000 00000000 0002 01 58140 @hil-cpu/choosing
0000000000000000: 00000002 00000000 00000000 0002 01 58141 @hil-cpu/1/\x1b[2J/78.12
0000000000000000: 00000002 00000000 00000000 0002 01 58142
"""


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> Iterator[ExitStack]:
    """Holders of this test alone, on four CPUs; what it holds is released."""
    monkeypatch.setattr(cpu_claim, "_PREFIX", f"hil-cpu-test-{os.getpid()}/")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1, 2, 5})
    with ExitStack() as stack:
        yield stack


def held(stack: ExitStack, configured: int | None, bench: str) -> CpuClaim:
    claim = claim_cpu(configured, bench)
    stack.callback(claim.release)
    return claim


def test_what_linux_lists() -> None:
    found = list(holders_in(LISTED))
    assert found == [Holder(1, "mill", "77.0"), Holder(3, "lathe", "78.12")]
    assert by_cpu(found) == {1: ["mill"], 3: ["lathe"]}


def test_the_least_held_of_several_the_last() -> None:
    one, two = Holder(3, "a", "1.0"), Holder(2, "b", "2.0")
    assert least_held({0, 1, 2, 3}, []) == 3
    assert least_held({0, 1, 2, 3}, [one]) == 2
    assert least_held({2, 3}, [one, two, one]) == 2
    assert least_held({0}, [one]) == 0


def test_each_takes_another_then_says_that_it_shares(alone: ExitStack) -> None:
    claims = [held(alone, None, f"b{number}") for number in range(4)]
    assert [claim.cpu for claim in claims] == [5, 2, 1, 0]
    assert [claim.shares() for claim in claims] == [""] * 4
    fifth = held(alone, None, "b4")
    assert (fifth.cpu, fifth.shares()) == (5, "shares CPU 5 with bench b0")
    assert claims[0].shares() == "shares CPU 5 with bench b4", "who came first says so, too"
    fifth.release()
    assert claims[0].shares() == ""


def test_a_configured_one_stays_and_others_avoid_it(alone: ExitStack) -> None:
    asked = held(alone, 5, "mill")
    assert held(alone, None, "lathe").cpu == 2
    again = held(alone, 5, "saw")
    assert (again.cpu, again.pin, again.shares()) == (5, 5, "shares CPU 5 with bench mill")
    line = Grant(80, 5, {}, claim=asked).line()
    assert line == "rt: ok (SCHED_FIFO 80, CPU 5, memory locked; shares CPU 5 with bench saw)"
    line = Grant(80, 5, {"real-time priority": "a remedy"}, claim=asked).line()
    assert line == "rt: late (no real-time priority; shares CPU 5 with bench saw): a remedy"


def test_many_are_counted(alone: ExitStack) -> None:
    first, *_ = [held(alone, 1, name) for name in ("a", "b", "c", "d", "e", "e")]
    assert first.shares() == "shares CPU 1 with benches b, c, d and 2 more"


def test_where_there_is_one_it_is_held_and_not_pinned_to(
    alone: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {1})
    claim = held(alone, None, "a")
    assert (claim.cpu, claim.pin) == (1, -1)


def test_who_is_stopped_while_it_chooses_holds_up_nobody(
    alone: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cpu_claim, "CHOOSING_S", 0.02)
    alone.enter_context(cpu_claim._turn())
    assert held(alone, None, "a").cpu == 5


def test_processes_that_start_together_and_are_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    prefix = f"hil-cpu-test-{os.getpid()}-p/"
    monkeypatch.setattr(cpu_claim, "_PREFIX", prefix)
    cpus = sorted(os.sched_getaffinity(0))
    started = [
        subprocess.Popen(
            [sys.executable, "-c", CLAIMS, prefix, f"b{number}"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for number in range(min(2 * len(cpus), 6))
    ]
    try:
        chosen = [int(each.stdout.readline()) for each in started if each.stdout]
        counts = [chosen.count(cpu) for cpu in cpus]
        assert max(counts) - min(counts) <= 1, counts
        assert sorted(each.bench for each in holders()) == [f"b{n}" for n in range(len(started))]
    finally:
        for each in started:
            each.kill()
            each.communicate(timeout=60)
    give_up_s = time.monotonic() + 60
    while holders() and time.monotonic() < give_up_s:
        select.select([], [], [], 0.01)
    assert holders() == []
