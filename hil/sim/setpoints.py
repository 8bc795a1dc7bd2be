"""Time-out of set-points in a stream: the axis stops when the stream does, at the exact simulated time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from hil.vocab.time import FOREVER, SimTimeNs
from hil.vocab.verbs import Effect

NOTE = "set-points"


@dataclass(frozen=True)
class TimeOut:
    """Time-out and what happens then: ``policy`` of ``hil.config.model``, carried out by ``starve`` of the
    profile's ``verbs.py``."""

    after_ns: int
    policy: str
    acceleration_rpm_per_s: float
    starve: Callable[..., bool | None]


class Setpoints:
    """Set-points of one device's axes; without a ``TimeOut`` they are awaited forever. ``named``: arguments
    that tell a function of the profile which axis is meant, by the axis's name."""

    def __init__(self, time_out: TimeOut | None, named: Mapping[str, Mapping[str, str]]) -> None:
        self._time_out = time_out
        self._named = named
        self._due_ns: dict[str, SimTimeNs] = {}
        """Times at which axes have to stop, unless a set-point comes before, by name."""
        self._stops = dict.fromkeys(named, 0)
        self.due_ns = FOREVER
        """The first of these times."""

    @property
    def starved(self) -> int:
        """Number of times that an axis stopped."""
        return sum(self._stops.values())

    def note(
        self, axis: str, effect: Effect, now_ns: SimTimeNs, note: Callable[[str, str | None], None]
    ) -> None:
        if self._time_out is None or effect == Effect.NONE:
            return
        self._due_ns.pop(axis, None)
        if effect == Effect.STREAM:
            self._due_ns[axis] = SimTimeNs(now_ns + self._time_out.after_ns)
        self._find_next()
        note(self._topic(axis), None)

    def starve(self, now_ns: SimTimeNs, firmware: Any, note: Callable[[str, str | None], None]) -> None:
        """Stop the axes whose time is over."""
        assert self._time_out is not None
        policy, ms = self._time_out.policy, self._time_out.after_ns / 1e6
        over = [axis for axis, due_ns in self._due_ns.items() if due_ns <= now_ns]
        for axis in over:
            del self._due_ns[axis]
        self._find_next()
        for axis in over:
            stop, acceleration_rpm_per_s = self._time_out.starve, self._time_out.acceleration_rpm_per_s
            if stop(firmware, policy, acceleration_rpm_per_s, **self._named[axis]) is False:
                continue
            self._stops[axis] += 1
            note(self._topic(axis), f"no set-point for {ms:g} ms: {policy} ({self._stops[axis]} times)")

    def end(self) -> None:
        self._due_ns.clear()
        self.due_ns = FOREVER

    def _find_next(self) -> None:
        self.due_ns = min(self._due_ns.values(), default=FOREVER)

    def _topic(self, axis: str) -> str:
        return f"{NOTE} of {axis}" if self._named.get(axis) else NOTE
