"""Wall clock of a bench: start of the core's real-time thread, and how long the event loop serves it."""

import asyncio
import gc
import time
from collections.abc import Callable
from contextlib import AsyncExitStack

from hil.config import BenchConfig
from hil.host.cpu_claim import claim_cpu
from hil.host.real_time import Grant, grant, is_asked, refused, wanted_priority
from hil.live.refusals import StartError
from hil.sim.bench import BenchRuntime


class WallClock:
    """Conversion between simulated and wall time, both in nanoseconds; wall time is counted from 1970.
    ``epoch_ns``: the wall's time at simulated time 0."""

    def __init__(self, bench: BenchRuntime, speed: float, epoch_ns: int) -> None:
        self.epoch_ns = epoch_ns
        self._bench = bench
        self._speed = speed

    def times_ns(self) -> tuple[int, int]:
        now_ns = self._bench.now_ns
        return now_ns, self.wall_ns(now_ns)

    def wall_ns(self, sim_ns: int) -> int:
        return self.epoch_ns + round(sim_ns / self._speed)

    def sim_ns(self, wall_ns: int) -> int:
        return round((wall_ns - self.epoch_ns) * self._speed)

    def anchor(self) -> None:
        """Let the bench's present be the wall's: its time stood, and goes on."""
        self.epoch_ns = epoch_of(self._bench, self._speed)


def epoch_of(bench: BenchRuntime, speed: float) -> int:
    """Wall's time of simulated time 0, if the bench's present is the wall's."""
    return time.time_ns() - round(bench.now_ns / speed)


TURN_S = 0.02
"""Event loop time for one group that is late: as long as the longest step of a healthy firmware."""


def turn() -> Callable[[], bool]:
    """Make a function that says whether the turn of a group that begins now is over."""
    end_s = time.monotonic() + TURN_S
    return lambda: time.monotonic() > end_s


def start_core(
    stack: AsyncExitStack, bench: BenchRuntime, config: BenchConfig, *, require_rt: bool
) -> tuple[WallClock, Grant]:
    """Start the bench's time, which the event loop serves until ``stack`` is put away.

    Raises:
        StartError: there can be no such thread, or none with the rights that are required.
    """
    if why := refused(config.cpu):
        raise StartError(why)
    # A full collection would stop the event loop for 0.2 s per million objects. There is none before, either:
    # a start leaves 550 objects of 100,000 behind, and to find them takes a tenth of its time.
    gc.freeze()
    gc.enable()
    priority, claim = wanted_priority(), claim_cpu(config.cpu, config.bench)
    stack.callback(claim.release)
    try:
        bench.real_time.start(1_000_000_000 // config.rate_hz, config.speed, priority, claim.pin)
    except OSError as error:
        raise StartError(f"the core's thread could not be started: {error.strerror}") from error
    epoch_ns = epoch_of(bench, config.speed)
    asked = is_asked(config.cpu, require_rt)
    granted = grant(bench.core.native.rt_stats(), priority, claim.pin, asked=asked, claim=claim)
    if granted.missing and require_rt:
        raise StartError(granted.line())
    loop = asyncio.get_running_loop()
    loop.add_reader(bench.core.event_fd, bench.real_time.service)
    stack.callback(loop.remove_reader, bench.core.event_fd)
    return WallClock(bench, config.speed, epoch_ns), granted
