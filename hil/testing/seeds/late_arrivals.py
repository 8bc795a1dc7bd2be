"""Bytes that come some time after they were written, within a window."""

import random
from bisect import insort
from collections.abc import Iterator
from contextlib import contextmanager

from hil.sim.bench import BenchRuntime
from hil.sim.inputs import Bytes, Input
from hil.vocab.time import FOREVER, NS_PER_MS, SimTimeNs

MOST_MS = 60_000
"""Maximum window: a minute."""


class LateArrivals:
    """Pieces that a test or its program has written, and that are not there yet. Each comes at a time that
    is drawn from the window behind its writing; of one target none overtakes another.

    A piece takes effect as if it had been written at that time: an input log has it there."""

    def __init__(self, window_ms: float, chance: random.Random) -> None:
        if not 0 <= window_ms <= MOST_MS:
            raise ValueError(f"a window of arrival is 0 to {MOST_MS} ms, not {window_ms:g}")
        self.window_ms = window_ms
        self._window_ns, self._chance = round(window_ms * NS_PER_MS), chance
        self._waiting: list[tuple[SimTimeNs, int, str, Input]] = []
        self._count = 0
        self._last_ns: dict[str, SimTimeNs] = {}
        self._runtime: BenchRuntime | None = None
        self._is_paused = False

    def begin(self, runtime: BenchRuntime) -> None:
        """Begin to hold back what comes to a bench."""
        self._runtime = runtime

    @property
    def due_ns(self) -> SimTimeNs:
        """Time of the next piece; ``FOREVER``: none is on its way."""
        return self._waiting[0][0] if self._waiting else FOREVER

    def hold(self, target: str, given: Input) -> bool:
        """Hold back an input if it is bytes; answers whether it did."""
        if not isinstance(given, Bytes) or not self._window_ns or not self._runtime:
            return False
        drawn_ns = self._runtime.now_ns + self._chance.randrange(self._window_ns + 1)
        at_ns = SimTimeNs(max(drawn_ns, self._last_ns.get(target, 0)))
        self._last_ns[target] = at_ns
        self.arrive(at_ns, target, given)
        return True

    def arrive(self, at_ns: SimTimeNs, target: str, given: Input) -> None:
        """Let an input come at a time."""
        self._count += 1
        insort(self._waiting, (at_ns, self._count, target, given), key=lambda each: each[:2])

    def passed(self, now_ns: SimTimeNs) -> None:
        """Let those take effect whose time has come."""
        while self._runtime and self._waiting and self._waiting[0][0] <= now_ns and not self._is_paused:
            _, _, target, given = self._waiting.pop(0)
            self._runtime.apply_input(target, given, now_ns)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Let nothing arrive for the block."""
        self._is_paused = True
        try:
            yield
        finally:
            self._is_paused = False
