"""The motion engine of a stepper, with names instead of numbers."""

from collections.abc import Mapping

from hil.core.abi import Call
from hil.core.core_axis import CoreAxis
from hil.vocab.motion import CONTINUOUS_SLOT, MotionEntry, MotionSetup

_RETARGET = Call.retarget
"""Looked up once: to find it in its class takes as long as the call, which each node of a line makes."""


def entry_of(values: Mapping[str, int]) -> MotionEntry:
    """Make an entry from the numbers that the core holds."""
    flags = ("is_ccw", "is_linear", "is_sync", "is_pulses")
    return MotionEntry(**{name: bool(v) if name in flags else v for name, v in values.items()})  # type: ignore[arg-type]


class CoreMotion(CoreAxis):
    """Axis of a stepper; a firmware sees it as ``hil.vocab.motion.Motion``."""

    def loop(self, on: bool) -> None:
        """End all motion where a control loop would be stopped: a stepper has none."""
        if not on:
            self.stop(None)

    def setup(self, setup: MotionSetup) -> None:
        self._native.motion_setup(self.id, {name: int(value) for name, value in vars(setup).items()})

    def entry(self, slot: int) -> MotionEntry:
        return entry_of(self._native.motion_read(self.id, slot))

    def write_entry(self, slot: int, entry: MotionEntry) -> None:
        self._native.motion_write(self.id, slot, {name: int(value) for name, value in vars(entry).items()})

    def enqueue(self, slot: int) -> None:
        self._do(Call.enqueue, slot)

    def run_once(self, slot: int) -> None:
        self._do(Call.once, slot)

    def run_continuous(self) -> None:
        self._do(Call.once, CONTINUOUS_SLOT)

    def retarget(self, rpm: int, cycle_us: int) -> None:
        self._native.do(self.id, _RETARGET, rpm, cycle_us, 0)

    def pulse(self, ccw: bool) -> None:
        self._do(Call.pulse, ccw)

    def stop(self, dec_hundredths: int | None) -> None:
        self._do(Call.stop, -1 if dec_hundredths is None else dec_hundredths)

    def next(self, is_graceful: bool) -> None:
        self._do(Call.next, is_graceful)

    def finish(self) -> None:
        self._do(Call.finish)

    def loop_start(self, slot: int) -> None:
        self._do(Call.loop_bounds, slot, 0)

    def loop_finish(self, slot: int) -> None:
        self._do(Call.loop_bounds, 0, slot)

    def loop_passes(self, passes: int) -> None:
        self._do(Call.loop_passes, passes)

    def loop_array(self, passes: int) -> None:
        self._do(Call.loop_array, passes)

    def xref(self) -> tuple[int, ...]:
        return self._native.motion_xref(self.id)

    def write_xref(self, index: int, slot: int) -> None:
        self._native.motion_xref_write(self.id, index, slot)

    def release_sync(self) -> None:
        self._do(Call.release_sync)

    def gap(self, on: bool) -> None:
        self._do(Call.gap, on)

    def encoder_mode(self, is_throttle: bool) -> None:
        self._do(Call.throttle, is_throttle)

    def report(self, on: bool) -> None:
        self._do(Call.report, on)

    def _do(self, call: int, x: int = 0, y: int = 0) -> None:
        self._native.do(self.id, call, x, y, 0)
