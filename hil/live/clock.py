"""Wall clock of a bench."""

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
