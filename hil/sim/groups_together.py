"""Groups that go on together in virtual time: the core moves their axes side by side, and firmwares run in
the order of times, those of one time in the order of the groups.

Axes of many groups move faster together than one after the other. No group is waited for: those of which
nobody can hear before their firmwares run are left behind, until the first of these is due, and then go on at
once.
"""

from collections.abc import Sequence
from heapq import heappop, heappush
from typing import Protocol

from hil.core import Core
from hil.sim.group import Group
from hil.vocab.time import FOREVER, NS_PER_MS, SimTimeNs

SLICE_NS = 100 * NS_PER_MS
"""Time by which groups are ahead of the firmware that runs at the most, so that they go on together again."""

UNQUIET_NS = NS_PER_MS
"""Time by which a byte of a group whose axes may wake its firmware may be noticed late at the most: a host
looks for bytes on USB once in a millisecond."""


def advance_together(
    core: Core, groups: Sequence[Group], until_ns: SimTimeNs, limits_ns: Sequence[SimTimeNs] = ()
) -> None:
    """Run axes and firmwares of groups, at least one, up to and at ``until_ns``; never back. ``limits_ns``:
    of each group, where it goes less far."""
    if not limits_ns:
        due_ns = [group.due_ns for group in groups]
        ids = [group.id for group in groups]
        if min(due_ns) > until_ns and not core.native.advance_groups(ids, due_ns, until_ns):
            return  # no firmware runs until then
    together = _Together(core, groups, limits_ns or [until_ns] * len(groups))
    end_ns = SimTimeNs(-1)
    while end_ns < until_ns:
        due_ns = [group.due_ns for group in groups]
        end_ns = SimTimeNs(min(max(min(due_ns), end_ns) + SLICE_NS, until_ns))
        together.advance(due_ns, end_ns)


class HeardLine(Protocol):
    """Line at which somebody outside listens. ``address``: of what is behind it, as inputs have it."""

    address: str

    @property
    def next_ns(self) -> SimTimeNs:
        """Time at which the next byte is complete, of those on the line; ``FOREVER``: none is."""


def advance_until_heard(
    groups: Sequence[Group], lines: Sequence[HeardLine], limit_ns: SimTimeNs
) -> SimTimeNs:
    """Run axes and firmwares of the groups of some lines up to the time of the next byte there, no further
    than a limit; answers the time. No group runs ahead of it: what is sent then takes effect at that time."""
    while True:
        now_ns, end_ns = groups[0].now_ns, limit_ns
        for line in lines:
            if (at_ns := line.next_ns) < end_ns:
                end_ns = at_ns
        if end_ns <= now_ns:
            return now_ns
        for group in groups:
            if (due_ns := group.due_ns) < end_ns:
                end_ns = due_ns
            if end_ns > now_ns + UNQUIET_NS and not group.is_quiet:
                end_ns = SimTimeNs(now_ns + UNQUIET_NS)
        for group in groups:
            group.advance(end_ns)


class _Together:
    def __init__(self, core: Core, groups: Sequence[Group], limits_ns: Sequence[SimTimeNs]) -> None:
        self._native = core.native
        self._groups = groups
        self._limits_ns = limits_ns
        self._behind = set[int]()
        """Places of groups that the core may take on, and that nobody hears of until then."""
        self._turns: list[tuple[SimTimeNs, int]] = []
        """Heap of times and places; outdated where ``_turn_ns`` has another time."""
        self._turn_ns: dict[int, SimTimeNs] = {}

    def advance(self, due_ns: list[SimTimeNs], end_ns: SimTimeNs) -> None:
        """Run all groups up to and at a time. ``due_ns``: their horizons now."""
        self._advance(list(range(len(self._groups))), due_ns, end_ns)
        while self._behind or self._turns:
            if not self._turns:
                self._catch_up(end_ns)
                continue
            at_ns, place = heappop(self._turns)
            if self._turn_ns.get(place) != at_ns:
                continue
            del self._turn_ns[place]
            if place in self._behind:
                self._catch_up(end_ns)
            else:
                self._take_turn(place, end_ns)

    def _catch_up(self, end_ns: SimTimeNs) -> None:
        """Let the core take on all that are behind, as far as their firmwares let it."""
        places = sorted(self._behind)
        self._behind.clear()
        self._advance(places, [self._groups[place].due_ns for place in places], end_ns)

    def _advance(self, places: list[int], due_ns: list[SimTimeNs], end_ns: SimTimeNs) -> None:
        while places:
            groups = [self._groups[place] for place in places]
            ends_ns = [min(end_ns, self._limits_ns[place]) for place in places]
            horizons_ns = [min(of, end) for of, end in zip(due_ns, ends_ns, strict=True)]
            found = self._native.advance_groups([group.id for group in groups], horizons_ns, end_ns)
            turns = [(at, groups[at].turn_ns()) for at in found]
            for at, turn_ns in turns:
                if turn_ns <= ends_ns[at]:
                    self._note(places[at], turn_ns)
            left = [at for at, turn_ns in turns if turn_ns == FOREVER and groups[at].now_ns < ends_ns[at]]
            places, due_ns = [places[at] for at in left], [due_ns[at] for at in left]

    def _take_turn(self, place: int, end_ns: SimTimeNs) -> None:
        group, end_ns = self._groups[place], min(end_ns, self._limits_ns[place])
        group.take_turn()
        next_ns = group.turn_ns()
        if next_ns < FOREVER:
            self._note(place, next_ns)
        elif group.now_ns < end_ns:
            if self._native.is_quiet(group.id):
                self._behind.add(place)
                if (due_ns := group.due_ns) <= end_ns:
                    self._note(place, due_ns)
            else:
                self._advance([place], [group.due_ns], end_ns)

    def _note(self, place: int, turn_ns: SimTimeNs) -> None:
        self._turn_ns[place] = turn_ns
        heappush(self._turns, (turn_ns, place))
