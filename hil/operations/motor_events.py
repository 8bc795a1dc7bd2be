"""Events of motors: steps that were lost, servos that push and stand, drivers that are too hot."""

import logging
from collections.abc import Iterator

from hil.core import CoreAxis
from hil.core.motor_words import blocked_note, heat_note, stall_note
from hil.operations.event_log import EventLog
from hil.sim.bench import BenchRuntime

KIND = "motors"
LOOKS_BLOCKED = 2
"""Looks in a row at which a servo is blocked, and not only turns round."""
STALLS = "stalls"
"""Field that counts how often a motor has lost steps."""
TRIPS = "thermal_trips"
"""Field that counts how often a driver was too hot."""
HOT = "its driver is too hot: no current until it has cooled"
"""Text of the event of a driver whose heat has switched its outputs off."""
_SLICE = 16
"""Axes between two turns of others."""
_HERE = "bench"
"""Asker of what nobody asked for."""

log = logging.getLogger("hil")


class MotorEvents:
    """Looks at all motors of a bench, and notes in its events what has changed since the look before."""

    def __init__(self, events: EventLog, sim: BenchRuntime) -> None:
        self._events, self._sim = events, sim
        known = events.told(0)["events"]  # a bench that goes on from a recorded run has its stalls, too
        self._stalled_ns: dict[str, int] = {
            event["of"]: event["at_ns"] for event in known if event["kind"] == KIND
        }
        """Times of the latest stalls that were noted, by the axis's address: counts begin again with a
        power-up, and times do not."""
        self._heat_ns = dict(self._stalled_ns)
        """Times of the latest shutdowns and returns of drivers that were noted, by the axis's address."""
        self._blocked: dict[str, int] = {}
        """Looks in a row at which a servo was blocked, by its address."""

    def look(self) -> Iterator[None]:
        """Look at all motors once; others have their turn at each ``yield``."""
        for number, (label, (device, part)) in enumerate(list(self._sim.parts.axes.items()), 1):
            axis = device.axes[part]
            if STALLS in axis.kind.fields:
                self._look_at_stepper(label, axis)
            elif axis.kind.encoder_counts:
                self._look_at_servo(label, axis)
            if TRIPS in axis.kind.fields:
                self._look_at_driver(label, axis)
            if number % _SLICE == 0:
                yield None

    def _look_at_stepper(self, label: str, axis: CoreAxis) -> None:
        shot = axis.published()
        if shot.stalls and shot.stalled_at_ns > self._stalled_ns.get(label, 0):
            self._stalled_ns[label] = shot.stalled_at_ns
            self._note(label, stall_note(shot.as_dict(), axis), shot.stalled_at_ns)

    def _look_at_servo(self, label: str, axis: CoreAxis) -> None:
        """Note a servo that was blocked at the last look, too."""
        text = blocked_note(axis.published().as_dict(), axis)
        looks = self._blocked[label] = self._blocked.get(label, 0) + 1 if text else 0
        if looks == LOOKS_BLOCKED:
            self._note(label, text, None)

    def _look_at_driver(self, label: str, axis: CoreAxis) -> None:
        """Note a driver that has switched its outputs off for its heat, and one that has them on again."""
        shot, noted_ns = axis.published(), self._heat_ns.get(label, 0)
        if shot.thermal_trips and shot.too_hot_at_ns > noted_ns:
            self._note(label, HOT, shot.too_hot_at_ns)
        if shot.thermal_trips and not shot.is_too_hot and shot.cooled_at_ns > noted_ns:
            self._note(label, heat_note(shot.as_dict()), shot.cooled_at_ns)
        self._heat_ns[label] = max(noted_ns, shot.too_hot_at_ns, shot.cooled_at_ns)

    def _note(self, label: str, text: str, at_ns: int | None) -> None:
        log.warning("%s: %s", label, text)
        self._events.put(KIND, label, _HERE, text, at_ns=at_ns)
