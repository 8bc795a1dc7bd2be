"""Real drive as a device of a bench."""

import errno
import os
from collections.abc import Callable, Coroutine, Iterator, Mapping
from fractions import Fraction
from typing import Any

from hil.drives.drive_control import DriveControl
from hil.drives.drive_fields import packed
from hil.drives.drive_link import SharedLines
from hil.live.devices.real_device import NO_PORT, RealDevice, port_counters
from hil.live.motion_wait import motion_ended
from hil.vocab.axis import Axis, AxisNow
from hil.vocab.desk_protocol import AxisLook, DeviceInfo, Done, Watch
from hil.vocab.monitoring import HealthProblem
from hil.vocab.ports import EchoStats
from hil.vocab.verbs import VerbRefused

_END_LOOK_S = 0.02
AWAY_NS = 500_000_000
"""Interval in which the state of a drive that is not there is told."""
_BACK = {
    os.strerror(errno.EAFNOSUPPORT): "let the kernel have CAN: `modprobe can_raw`, and the adapter's driver",
    os.strerror(errno.ENODEV): "plug the adapter in; `ip link` shows what its interface is called",
    os.strerror(errno.ENETDOWN): "bring the interface up: `ip link set can0 up type can bitrate 1000000`",
    "bus-off": "mend the bus: bit rate, wires, terminators; with `restart-ms` it comes back by itself",
}
"""Remedies by words of the reason for which it is not there."""
_COUNTERS = ("polls", "writes", "time_outs", "garbled", "exceptions")


class DriveDevice(RealDevice):
    """Real drive, as ``hil.vocab.device.Device``. ``lines``: those that the bench's drives share."""

    faults = None
    is_talking = False

    def __init__(
        self, control: DriveControl, lines: SharedLines, profile: str, at: str | None, speed: float
    ) -> None:
        super().__init__(control.drive.name, at, speed)
        self._control, self._lines, self._profile = control, lines, profile
        self._drive, self._axis = control.drive, control.axis
        self._has_stopped = False

    def info(self, part: str) -> DeviceInfo:
        if part:
            raise KeyError(part)
        return DeviceInfo(self.name, self._profile, True, self._drive.verbs, self._drive.fields)

    def refusal(self) -> VerbRefused:
        return VerbRefused(
            "cannot", f"{self.name} is a real drive: hil has its registers, not its pins, line or samples"
        )

    # ---- what it can be told ----

    async def do(self, part: str, verb: str, parameters: Mapping[str, float | str]) -> Done:
        """Carry out a verb; answers when the drive has confirmed it."""
        answer = await self._control.do(verb, parameters)
        return Done(self._drive.now_ns(), answer)

    def reset(self) -> Coroutine[Any, Any, Done]:
        if "reset" not in self._drive.verbs:
            raise VerbRefused("cannot", f"the map of {self.name} has no control bit reset")
        return self.do("", "reset", {})

    def set(self, part: str, field: str, value: Any) -> Coroutine[Any, Any, Done]:
        """Write a parameter of the map."""
        known = [each for each, told in self._drive.fields.items() if told.is_settable]
        if field not in known:
            there = (
                f"that can be set are {', '.join(known)}" if known else "cannot be set: it has no parameters"
            )
            raise VerbRefused("no_parameter", f"fields of {self.name} {there}")
        return self._set(field, value)

    async def _set(self, field: str, value: Any) -> Done:
        await self._control.set(field, value)
        return Done(self._drive.now_ns(), {field: value})

    def zero(self, part: str) -> Done:
        raise VerbRefused("cannot", f"{self.name} is a real drive: its own homing makes its zero")

    # ---- what it tells ----

    def state(self, part: str) -> dict[str, float | None]:
        told = self._drive.values()
        return {field: value if abs(value) < float("inf") else None for field, value in told.items()}

    def packed(self, part: str) -> bytes:
        return packed(self._drive.fields, self._drive.values())

    def look(self, part: str) -> AxisLook:
        return AxisLook(self.packed(part), self._axis.state(), self._axis.failure)

    async def wait(
        self,
        part: str,
        effective_at_ns: int,
        at_most_s: float,
        ends_after_ns: float | None,
        set_point: float | None,
    ) -> dict[str, bool]:
        axis, drive = self._axis, self._drive
        session = drive.link.session

        def was_cut_short() -> bool | None:
            is_in = drive.is_in(session)
            return None if axis.motion.is_under_way and is_in else axis.failure is not None or not is_in

        return await motion_ended(
            was_cut_short, drive.now_ns, effective_at_ns, at_most_s, lambda: _END_LOOK_S
        )

    def watch(
        self, part: str, interval_ns: int | Fraction, points: int, call: Callable[[bytes], object]
    ) -> Watch:
        return DriveSamples(self._control, float(interval_ns), call)

    def signals(self, part: str, names: object) -> tuple[str, ...]:
        raise VerbRefused(
            "cannot", f"{self.name} is a real drive: its polls are no samples; ask for its state"
        )

    # ---- as an axis of runs ----

    def axes(self) -> Mapping[str, AxisNow]:
        return {self.name: self.in_time(self._axis.now(), "drives")}

    def axis(self, part: str) -> Axis:
        return self._axis

    # ---- how it does ----

    @property
    def is_there(self) -> bool:
        return self._drive.link.is_there

    @property
    def where(self) -> str:
        away = "" if self.is_there else f" ({self._drive.link.state}, tried again)"
        return f"the drive at {self._drive.address}{away}"

    def counters(self) -> Mapping[str, int]:
        return vars(self._drive.link.counters)

    def echoes(self) -> Iterator[tuple[str, EchoStats | None]]:
        yield self.name, self._drive.echo

    def status(self) -> dict[str, Any]:
        drive, told = self._drive, self.state("")
        link = drive.link
        notes = [] if link.is_there else [f"{drive.address}: {link.why}; it is tried again"]
        if link.is_there:
            notes += [*([drive.fault] if drive.fault else []), *drive.notes]
        return {
            **port_counters(NO_PORT),
            "backlog_bytes": 0,
            "overrun_bytes": 0,
            "note": "; ".join(notes) or None,
            "flash": "ok",
            "port_failure": None,
            "snapshot": told if drive.reading else None,
            "snapshots": {},
            "drive": {
                "state": link.state,
                "age_ms": told["age_ms"],
                **{name: told[name] for name in _COUNTERS},
                **{name: told[name] for name in ("reconnects", "round_trip_p50_ms", "round_trip_p99_ms")},
                "identity": dict(drive.identity),
            },
        }

    def problems(self, is_service: bool) -> Iterator[HealthProblem]:
        if (link := self._drive.link).is_tried and not link.is_there:
            back = next(
                (remedy for said, remedy in _BACK.items() if said in link.why),
                "see that it has power, its address and its unit or node",
            )
            what = f"{self._drive.address}: {link.why}"
            yield HealthProblem("port", self.name, what, f"{back}; it is tried again")

    # ---- its life ----

    async def begin(self) -> None:
        self._control.begin(self._lines)

    def leave(self) -> None:
        """Leave nothing behind: it has no place in simulated time."""

    async def stop(self) -> None:
        if not self._has_stopped:
            self._has_stopped = True
            await self._axis.end()

    async def close(self) -> None:
        await self.stop()  # one that a reload takes away goes on moving until here
        await self._control.end(self._lines)


class DriveSamples:
    """Watch on a drive: its state, each time that it has told a new one, and while it is not there now and
    then with its age. Polls have their own times, which are no multiples of an interval."""

    lost = 0

    def __init__(self, control: DriveControl, interval_ns: float, call: Callable[[bytes], object]) -> None:
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
