"""Operations on one real drive, in the words of those on a twin."""

from collections.abc import Coroutine, Mapping
from typing import Any

from hil.drives.drive_fields import packed
from hil.live.drives.drive_axes import Drives
from hil.live.drives.drive_control import DriveControl
from hil.live.motion_wait import motion_ended
from hil.sim.bench import BenchRuntime
from hil.vocab.desk_protocol import AxisLook, Done
from hil.vocab.verbs import VerbRefused

_POLL_S = 0.02
AWAY_NS = 500_000_000
"""Interval in which the state of a drive that is not there is told."""


class DriveOperations:
    """Operations on the drives of a bench."""

    def __init__(self, sim: BenchRuntime, drives: Drives) -> None:
        self._sim = sim
        self._drives = drives

    def __contains__(self, name: str) -> bool:
        return name in self._drives

    def _control(self, name: str) -> DriveControl:
        if (control := self._drives.get(name)) is None:
            raise VerbRefused("no_device", f"no device {name!r}; a reload has taken it away")
        return control

    async def do(self, name: str, verb: str, parameters: Mapping[str, float | str]) -> Done:
        """Carry out a verb; answers when the drive has confirmed it."""
        answer = await self._control(name).do(verb, parameters)
        return Done(self._sim.now_ns, answer)

    def set_field(self, name: str, field: str, value: Any) -> Coroutine[Any, Any, Done]:
        """Write a parameter of the map."""
        control = self._control(name)
        known = [each for each, told in control.drive.fields.items() if told.is_settable]
        if field not in known:
            there = (
                f"that can be set are {', '.join(known)}" if known else "cannot be set: it has no parameters"
            )
            raise VerbRefused("no_parameter", f"fields of {name} {there}")
        return self._set(control, field, value)

    async def _set(self, control: DriveControl, field: str, value: Any) -> Done:
        await control.set(field, value)
        return Done(self._sim.now_ns, {field: value})

    def state(self, name: str) -> dict[str, float | None]:
        """Fields of a drive; None for what is not told."""
        told = self._control(name).drive.values()
        return {field: value if abs(value) < float("inf") else None for field, value in told.items()}

    def packed(self, name: str) -> bytes:
        drive = self._control(name).drive
        return packed(drive.fields, drive.values())

    def look(self, name: str) -> AxisLook:
        axis = self._control(name).axis
        return AxisLook(self.packed(name), axis.state(), axis.failure)

    async def wait(self, name: str, effective_at_ns: int, at_most_s: float) -> dict[str, bool]:
        """Wait until the motion that a verb began has ended; answers whether something else ended it."""
        axis = self._control(name).axis
        session = axis.drive.link.session

        def was_cut_short() -> bool | None:
            is_in = axis.drive.is_in(session)
            return None if axis.motion.is_under_way and is_in else axis.failure is not None or not is_in

        return await motion_ended(
            was_cut_short, lambda: self._sim.now_ns, effective_at_ns, at_most_s, lambda: _POLL_S
        )

    def refuse(self, name: str) -> VerbRefused:
        """Refusal of what no real drive has."""
        return VerbRefused(
            "cannot", f"{name} is a real drive: hil has its registers, not its pins, line or samples"
        )


class DriveSamples:
    """Watch on a drive: its state, each time that it has told a new one, and while it is not there now and
    then with its age. Polls have their own times, which are no multiples of an interval."""

    lost = 0

    def __init__(self, control: DriveControl, interval_ns: float, call: Any) -> None:
        self._drive, self._interval_ns, self._call = control.drive, interval_ns, call
        self._told_ns, self._was_there = -1.0, False

    def flush(self) -> None:
        """Hand over the state, if it is a new one, and the interval is over."""
        reading, is_there = self._drive.reading, self._drive.link.is_there
        if reading is None:
            return
        at_ns = reading.at_ns if is_there else self._drive.now_ns()
        interval_ns = self._interval_ns * 0.9 if is_there else AWAY_NS  # polls are not exact
        if at_ns - self._told_ns >= interval_ns or is_there != self._was_there:
            self._told_ns, self._was_there = at_ns, is_there
            self._call(packed(self._drive.fields, self._drive.values()))

    def close(self) -> None:
        """Do nothing: it holds nothing."""
