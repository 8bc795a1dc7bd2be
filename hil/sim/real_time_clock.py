"""Real time: the core's thread takes groups to the wall's time, and calls their firmwares here."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext

from hil.core import Core
from hil.sim.group import Group
from hil.vocab.time import SimTimeNs

LAG_BUCKETS = 40
_NOTHING = nullcontext()


class RealTimeClock:
    """Clock of a bench in real time, which shares its ``groups``. Until ``start``, and after ``stop``, the
    groups are the caller's: owning one does nothing. ``turn_over``, ``turn``: those of ``BenchHooks``."""

    def __init__(
        self,
        core: Core,
        groups: Mapping[int, Group],
        turn_over: Callable[[], None],
        turn: Callable[[], Callable[[], bool] | None],
    ) -> None:
        self._core = core.native
        self._groups = groups
        self._turn_over, self._turn = turn_over, turn
        self.is_on = False
        self.is_held = False
        """True while time stands, or is not the clients' yet: who is outside waits."""
        self._options = 0, 1.0, 0, 0
        self.lag = [0] * LAG_BUCKETS
        """Lateness of firmware: bucket b counts lags of [2^(b-1), 2^b) ns."""
        self.lag_total_ns = 0

    @property
    def now_ns(self) -> SimTimeNs:
        """Time that the wall's time asks for."""
        return SimTimeNs(self._core.rt_now())

    def start(self, period_ns: int, speed: float, priority: int, cpu: int) -> None:
        """Hand the groups to the core's real-time thread; time goes on from where they are. While it is held,
        it stands.

        Raises:
            OSError: no thread could be started at all.
        """
        self._options = period_ns, speed, priority, cpu
        self._begin()

    def _begin(self) -> None:
        period_ns, speed, priority, cpu = self._options
        self._core.rt_start(period_ns, 0.0 if self.is_held else speed, priority, cpu)
        self.is_on = True
        for group in self._groups.values():
            group.advance(group.now_ns)
            group.give_back()
        self._turn_over()

    def hold(self, is_held: bool) -> None:
        """Let time stand, or go on from where it stands.

        Raises:
            OSError: the thread could not be started again.
        """
        self._core.rt_stop()
        self.is_held = is_held
        self._begin()

    def hand_over(self, groups: Iterable[Group], now_ns: SimTimeNs) -> None:
        """Hand over groups that the thread does not have, after their firmwares have run to this time."""
        for group in groups:
            group.advance(now_ns)
            if self.is_on:
                group.give_back()
        if self.is_on:
            self._turn_over()

    def service(self) -> None:
        """Run the firmware of every group that the core has parked or has events of."""
        for group_id in self._core.take_due():
            group = self._groups[group_id]
            if group.is_held:  # it stays at its horizon until it goes on
                continue
            with group:
                # Behind the wait for the group, in which the core's thread may have been.
                now_ns = self.now_ns
                due_ns = group.due_ns
                if due_ns <= now_ns:
                    self.lag[min((now_ns - due_ns).bit_length(), LAG_BUCKETS - 1)] += 1
                    self.lag_total_ns += now_ns - due_ns
                group.advance(now_ns, self._turn())
        self._turn_over()

    def stop(self) -> None:
        """End the real-time thread; the groups are the caller's again."""
        self._core.rt_stop()
        self.is_on = False

    def turn(self) -> Callable[[], bool] | None:
        """Function that says whether the turn of a group that begins now is over; None: it never is."""
        return self._turn() if self.is_on else None

    def owning(self, group: Group) -> AbstractContextManager[object]:
        """Own a group for the block: its firmwares may run."""
        return _Turn(group, self._turn_over) if self.is_on else _NOTHING

    def looking_at(self, group: Group) -> AbstractContextManager[object]:
        """Own a group for a block in which none of its firmwares runs."""
        return group if self.is_on else _NOTHING


class _Turn:
    """Ownership of a group; ``over`` is called when it is given back."""

    __slots__ = ("_group", "_over")

    def __init__(self, group: Group, over: Callable[[], None]) -> None:
        self._group = group
        self._over = over

    def __enter__(self) -> None:
        self._group.__enter__()

    def __exit__(self, *error: object) -> None:
        self._group.give_back()
        self._over()
