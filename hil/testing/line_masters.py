"""Masters of lines without I/O at the taps of a bench, in simulated time."""

from collections.abc import Callable, Mapping

from hil.testing.bench import Bench
from hil.testing.waiting import NotInTime
from hil.vocab.line_node import LineMaster
from hil.vocab.time import NS_PER_MS, SimTimeNs

SLICE_NS = 1 * NS_PER_MS
"""Time in which nothing that begins on the line can be complete unseen: an answer of 6 characters takes
1.5 ms at 38400 baud."""

MOST_TURNS = 1000
"""Maximum number of turns without time between them."""


def attend(
    bench: Bench, masters: Mapping[str, LineMaster], until: Callable[[], bool], *, within_ms: float = 60_000
) -> None:
    """Let masters work at taps, by their names, until ``until`` is true.

    Raises:
        NotInTime: that takes longer than ``within_ms``, simulated; or a master is due again and again at one
            time.
    """
    __tracebackhide__ = True
    end_ns = bench.now_ns + within_ms * NS_PER_MS
    turns, turned_ns = 0, -1
    while not _turn(bench, masters, until):
        turns, turned_ns = (turns + 1 if turned_ns == bench.now_ns else 0), bench.now_ns
        if turns > MOST_TURNS:
            raise NotInTime(f"a master is due at {bench.now_ns} ns again and again")
        if bench.now_ns >= end_ns:
            raise NotInTime(f"not at its end after {within_ms:g} ms")
        dues = [bench.tap(name).next_ns for name in masters] + [each.due_ns() for each in masters.values()]
        next_ns = min(*dues, bench.now_ns + SLICE_NS)
        bench.run_until(SimTimeNs(max(next_ns, bench.now_ns)) / NS_PER_MS)


def _turn(bench: Bench, masters: Mapping[str, LineMaster], until: Callable[[], bool]) -> bool:
    """Hand on what has come and what goes out; answers whether it is over."""
    for name, master in masters.items():
        tap = bench.tap(name)
        for at_ns, byte in tap.read_timed():
            master.receive(bytes((byte,)), at_ns)
        if master.due_ns() <= bench.now_ns:
            master.advance(bench.now_ns)
        if out := master.to_send():
            tap.write(out)
    return until()
