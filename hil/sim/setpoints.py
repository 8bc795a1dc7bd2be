"""Time-out of set-points in a stream: the axis stops when the stream does, at the exact simulated time."""

from collections.abc import Callable
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
    starve: Callable[..., None]


class Setpoints:
    """Set-points of one device; without a ``TimeOut`` it waits for ever."""

    def __init__(self, time_out: TimeOut | None) -> None:
        self._time_out = time_out
        self.due_ns = FOREVER
        """Time at which the axis has to stop, unless a set-point comes before."""
        self.starved = 0
        """Number of times that it stopped."""

    def note(self, effect: Effect, now_ns: SimTimeNs, note: Callable[[str, str | None], None]) -> None:
        if effect == Effect.NONE or self._time_out is None:
            return
        streams = effect == Effect.STREAM
        self.due_ns = SimTimeNs(now_ns + self._time_out.after_ns) if streams else FOREVER
        note(NOTE, None)

    def starve(self, firmware: Any, note: Callable[[str, str | None], None]) -> None:
        """Stop the axis, as the time is over."""
        assert self._time_out is not None
        self.due_ns = FOREVER
        self.starved += 1
        self._time_out.starve(firmware, self._time_out.policy, self._time_out.acceleration_rpm_per_s)
        ms = self._time_out.after_ns / 1e6
        note(NOTE, f"no set-point for {ms:g} ms: {self._time_out.policy} ({self.starved} times)")

    def end(self) -> None:
        self.due_ns = FOREVER
