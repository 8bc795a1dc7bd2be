"""Self-observation of the daemon: lateness of its event loop, missed wakes, log messages."""

import asyncio
import logging
from collections import deque
from typing import NamedTuple

from hil.sim.bench import BenchRuntime
from hil.sim.real_time_clock import LAG_BUCKETS

LOOP_LOOK_S = 0.1
"""Time between two looks at the event loop."""
WINDOW_LOOKS = 600
"""Looks in a minute: what is over for so long is no trouble any more."""


class _Look(NamedTuple):
    ticks: int
    missed: int
    loop_late_ns: int


class Vitals(logging.Handler):
    """Runs from ``start`` to ``stop``; as a handler of the log it counts messages by level."""

    def __init__(self, bench: BenchRuntime) -> None:
        super().__init__()
        self._bench = bench
        self._timer: asyncio.TimerHandle | None = None
        self._looks: deque[_Look] = deque(maxlen=WINDOW_LOOKS)
        self.messages = {"warning": 0, "error": 0}
        self.loop_lag = [0] * LAG_BUCKETS
        """Lateness of the event loop: bucket b counts [2^(b-1), 2^b) ns."""
        self.loop_lag_total_ns = 0

    def start(self) -> None:
        """Start; needs a running event loop."""
        logging.getLogger().addHandler(self)
        self._loop = asyncio.get_running_loop()
        self._due_s = self._loop.time()
        self._look()

    def stop(self) -> None:
        """Stop. Safe to call twice."""
        logging.getLogger().removeHandler(self)
        if self._timer:
            self._timer.cancel()
            self._timer = None

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno >= logging.WARNING:
            self.messages["error" if record.levelno >= logging.ERROR else "warning"] += 1

    def _look(self) -> None:
        now_s = self._loop.time()
        late_ns = max(round((now_s - self._due_s) * 1e9), 0)
        self.loop_lag[min(late_ns.bit_length(), LAG_BUCKETS - 1)] += 1
        self.loop_lag_total_ns += late_ns
        rt = self._bench.core.native.rt_stats()
        if self._looks and rt["ticks"] < self._looks[-1].ticks:  # from 0 again: time was held
            self._looks.clear()
        self._looks.append(_Look(rt["ticks"], rt["missed"], late_ns))
        self._due_s = now_s + LOOP_LOOK_S
        self._timer = self._loop.call_at(self._due_s, self._look)

    @property
    def missed_share(self) -> float:
        """Share of the wakes of the last minute that came too late to be one; 0 to 1."""
        if not self._looks:
            return 0.0
        first, last = self._looks[0], self._looks[-1]
        missed = last.missed - first.missed
        return missed / max(last.ticks - first.ticks + missed, 1)

    @property
    def loop_worst_ns(self) -> int:
        """Maximum lateness of the event loop in the last minute."""
        return max((look.loop_late_ns for look in self._looks), default=0)
