"""A group that is given back to the core's thread runs no further than its firmwares wait for."""

from typing import Any

from hil.testing import Bench
from hil.vocab.time import SimTimeNs

HALF_A_MINUTE_NS = 30_000_000_000


class Watched:
    """The native core, and the horizon that it was told last. Nobody takes the group, and nobody gets it."""

    def __init__(self, native: Any) -> None:
        self._native = native
        self.horizon_ns = 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._native, name)

    def advance(self, group: int, horizon_ns: int, until_ns: int) -> Any:
        self.horizon_ns = horizon_ns
        return self._native.advance(group, horizon_ns, until_ns)

    def acquire(self, group: int) -> None:
        return

    def release(self, group: int) -> None:
        return


def test_a_turn_that_ends_with_an_interrupt_leaves_the_horizon_of_what_it_caused() -> None:
    """DC1 and DC2 of soft_ops come from the interrupt at a motion's first and last pulse. They begin a packet
    on the line, whose end is a time that the group must not run past."""
    sacs = {f"s{n}": {"profile": "sac"} for n in (1, 2)}
    bench = Bench({"bench": "t", "devices": sacs, "segments": {"bus0": {"stations": ["s1", "s2"]}}})
    bench.run(1200)
    bench.port("s1").write(b"$O1\r")
    bench.run(100)
    bench.port("s1").write(b"m20\ry\r" * 3)
    group = bench._runtime.parts.group_of("s1")
    native = Watched(group._native)
    group._native = native  # type: ignore[assignment]
    end_ns, turns = SimTimeNs(group.now_ns + HALF_A_MINUTE_NS), 0
    while group.now_ns < end_ns and turns < 2000:
        with group:
            group.advance(end_ns, is_over=lambda: True)
        assert native.horizon_ns <= group.due_ns
        turns += 1
    said = bench.port("s1").read()
    assert {0x11, 0x12} <= set(said), "it has begun and ended a motion"
