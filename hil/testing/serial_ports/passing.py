"""Passing of simulated time while somebody waits at ports."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Protocol

from hil.sim.bench import BenchRuntime
from hil.testing.serial_ports.line_ends import LineEnd
from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs

FIRST_LOOK_NS = 10_000
LAST_LOOK_NS = 1_000_000
SILENCE_NS = 3600 * NS_PER_S
"""Simulated time after which a wait without a time-out, in which no byte comes, is one without end."""


class EndlessWait(Exception):
    """Error of a wait that nothing ends: ``str(error)`` says who waits for what."""


class Passing(Protocol):
    """Time of a bench, as those see it who wait at its ports."""

    @property
    def now_ns(self) -> SimTimeNs:
        """Present simulated time."""

    def wait(self, ready: Callable[[], bool], until_ns: int, what: str, end: LineEnd | None) -> None:
        """Let time pass until ``ready``, or ``until_ns``. ``what``: what is waited for, for people; ``end``:
        the line that it comes from.

        Raises:
            EndlessWait: there is no end to it.
        """

    def look(self) -> None:
        """Let the time of a look pass: of one after the other ever more, but not past a byte."""

    def acted(self) -> None:
        """Note that more than looking has happened."""

    def inside(self) -> AbstractContextManager[object]:
        """Context in which the bench works: what it calls itself takes no time."""


class Looks:
    """Time that looks cost: a program that only looks would stand still otherwise. Doubled with each look in
    a row, up to a millisecond."""

    def __init__(self) -> None:
        self._next_ns = FIRST_LOOK_NS

    def acted(self) -> None:
        """Begin again with short ones."""
        self._next_ns = FIRST_LOOK_NS

    def next_cost_ns(self) -> int:
        """Time of a look."""
        look_ns = self._next_ns
        self._next_ns = min(2 * look_ns, LAST_LOOK_NS)
        return look_ns


class OneThread:
    """Time that passes for a test's only thread. ``advance``: lets it pass until a line is heard;
    ``open_ends``: ends of the ports that are open now; ``passed``: called when time has passed, at
    ``stop_ns`` at the latest."""

    def __init__(
        self,
        runtime: BenchRuntime,
        advance: Callable[[SimTimeNs, list[LineEnd]], object],
        open_ends: Callable[[], list[LineEnd]],
        passed: Callable[[SimTimeNs], None],
        stop_ns: Callable[[], SimTimeNs],
    ) -> None:
        self._runtime, self._advance, self._open_ends = runtime, advance, open_ends
        self._passed, self._stop_ns = passed, stop_ns
        self._looks = Looks()
        self.acted = self._looks.acted
        self._inside = nullcontext()

    @property
    def now_ns(self) -> SimTimeNs:
        return self._runtime.now_ns

    def wait(self, ready: Callable[[], bool], until_ns: int, what: str, end: LineEnd | None) -> None:
        self.acted()
        give_up_ns = self.now_ns + SILENCE_NS if until_ns == FOREVER else FOREVER
        limit_ns = SimTimeNs(min(until_ns, give_up_ns))
        lines = [end] if end else []
        while not ready() and (now_ns := self.now_ns) < until_ns:
            if now_ns >= give_up_ns:
                raise EndlessWait(f"{what}: nothing has come for an hour of simulated time")
            self._advance(min(limit_ns, self._stop_ns()), lines)
            self._passed(self.now_ns)

    def inside(self) -> AbstractContextManager[object]:
        return self._inside

    def look(self) -> None:
        limit_ns = SimTimeNs(self.now_ns + self._looks.next_cost_ns())
        self._advance(limit_ns, self._open_ends())
        self._passed(self.now_ns)
