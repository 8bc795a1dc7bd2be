"""The wall's time and the bench's."""

from hil.sim.bench import BenchRuntime


class WallClock:
    """Translates between simulated time and nanoseconds of the wall since 1970."""

    def __init__(self, bench: BenchRuntime, speed: float, epoch_ns: int) -> None:
        self._bench = bench
        self._speed = speed
        self._epoch_ns = epoch_ns

    def times_ns(self) -> tuple[int, int]:
        """Simulated time and the wall's, now."""
        now_ns = self._bench.now_ns
        return now_ns, self.wall_ns(now_ns)

    def wall_ns(self, sim_ns: int) -> int:
        """The wall's time at a simulated one."""
        return self._epoch_ns + round(sim_ns / self._speed)

    def sim_ns(self, wall_ns: int) -> int:
        """The simulated time at one of the wall."""
        return round((wall_ns - self._epoch_ns) * self._speed)
