"""Doors of a bench in memory, each opened when a test first asks for it."""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

from hil.compose.find import make_memory_door
from hil.config import BenchConfig, Catalogue
from hil.sim.bench import BenchRuntime
from hil.testing.given import NoSuchName
from hil.vocab.time import FOREVER, SimTimeNs

if TYPE_CHECKING:
    from hil.memory_desk.desk_in_memory import MemoryDesk
    from hil.testing.doors.door_time import DoorTime


class BenchDoors:
    """Doors of a bench. ``run_until``: lets its time pass, ``stop_ns``: to which it may at once."""

    def __init__(
        self,
        runtime: BenchRuntime,
        config: BenchConfig,
        catalogue: Catalogue,
        run_until: Callable[[SimTimeNs], None],
        stop_ns: Callable[[], SimTimeNs],
    ) -> None:
        self._runtime, self._config, self._catalogue = runtime, config, catalogue
        self._run_until, self._stop_ns = run_until, stop_ns
        self._open: dict[str, Any] = {}
        self._is_closed = False

    def door(self, kind: str) -> Any:
        """Door of a bridge of this kind.

        Raises:
            KeyError: the configuration has none.
            ValueError: the bench is closed.
        """
        __tracebackhide__ = True
        if kind not in self._config.bridges:
            raise NoSuchName(
                f"the bench has no bridge {kind}; write `bridges: {{{kind}: {{}}}}` into its configuration"
            )
        if self._is_closed:
            raise ValueError("the bench is closed")
        if kind not in self._open:
            desk, time = self._desk.desk, self._time
            made = make_memory_door(kind, self._config.bridges[kind], desk, time)
            time.loop.complete(made.open())
            self._open[kind] = made
        return self._open[kind]

    @cached_property
    def _time(self) -> "DoorTime":
        from hil.memory_desk.door_loop import DoorLoop
        from hil.testing.doors.door_time import DoorTime

        runtime = self._runtime
        loop = DoorLoop(lambda: runtime.now_ns)
        return DoorTime(loop, lambda: runtime.now_ns, self._run_until, self._stop_ns)

    @cached_property
    def _desk(self) -> "MemoryDesk":
        from hil.memory_desk.desk_in_memory import memory_desk

        return self._time.loop.complete(memory_desk(self._runtime, self._config, self._catalogue))

    @property
    def due_ns(self) -> SimTimeNs:
        """Time at which something happens by itself at a door; ``FOREVER``: at none."""
        if not self._open:
            return FOREVER
        slice_ns = min(self._desk.sampler.period_ns or FOREVER, self._time.look_ns)
        return SimTimeNs(min(self._time.loop.due_ns, self._runtime.now_ns + slice_ns))

    def passed(self, now_ns: SimTimeNs) -> None:
        """Let the doors do what is due."""
        if self._open:
            self._desk.sampler.poll()
            self._time.loop.turn()

    def close(self) -> None:
        """Close the doors: their clients are cut off."""
        self._is_closed = True
        if "_time" in vars(self):
            for each in self._open.values():
                each.close()
            self._open.clear()
            self._time.close()
