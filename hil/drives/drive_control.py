"""Verbs of a real drive, one after the other."""

import asyncio
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

from hil.drives.drive_axis import DriveAxis
from hil.drives.drive_fields import FOLLOW_RPM, FOLLOW_RPM_PER_S
from hil.drives.drive_link import ASKING, LOST_AFTER, SharedLines
from hil.firmware.set_point_paths import length_ns, trapezoid
from hil.vocab.path import DEG_PER_S
from hil.vocab.verbs import VerbRefused

TAKES_S = 2.0
"""Time for a drive to do as it is told: to say that its loop is on, or off, or that its fault is gone."""
_STATE_LOOK_S = 0.01
AT_ANY_TIME = ("stop", "disable")
"""Verbs that are carried out also while a run has the drive; the run fails."""
BEGIN_NS = 50_000_000
"""Time until a stream that the daemon makes of a move begins."""


class DriveControl(ABC):
    """Control of one drive by verbs. Those of a kind of drive are its methods ``_enable``, ``_disable``,
    ``_clear_fault`` and ``_reset``, beside those that all have."""

    def __init__(self, axis: DriveAxis) -> None:
        self.axis = axis
        self.drive, self.motion = axis.drive, axis.motion
        self._lock = asyncio.Lock()

    @abstractmethod
    def begin(self, lines: SharedLines) -> None:
        """Begin to ask the drive, on a line that it may share."""

    @abstractmethod
    async def end(self, lines: SharedLines) -> None:
        """Ask it no more, and leave the line."""

    async def do(self, verb: str, given: Mapping[str, Any]) -> dict[str, float]:
        """Carry out a verb. Raises VerbRefused: it was not done, or nobody knows."""
        if self.axis.is_held and verb not in AT_ANY_TIME:
            raise VerbRefused("not_now", "a run has this drive; cancel it, or wait for its end")
        if verb in AT_ANY_TIME:
            self.axis.stopped_by(verb)
            self.motion.abandon()
        async with self._lock:
            self._check_there()
            try:
                answer: dict[str, float] = await getattr(self, f"_{verb}")(**given)
                return answer
            except ASKING as error:
                raise VerbRefused("not_now", f"{verb}: {error}") from None

    async def set(self, name: str, value: Any) -> None:
        """Write a parameter. Raises VerbRefused."""
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise VerbRefused("bad_parameter", f"{name}: write a number")
        async with self._lock:
            self._check_there()
            try:
                await self._write_parameter(name, value)
            except ValueError as error:
                raise VerbRefused("bad_parameter", f"{name}: {error}") from None
            except ASKING as error:
                raise VerbRefused("not_now", f"{name}: {error}") from None

    @abstractmethod
    async def _write_parameter(self, name: str, value: float) -> None:
        """Write a parameter that there is. Raises ``ASKING``; ValueError: it cannot be held."""

    @property
    @abstractmethod
    def has_own_ramps(self) -> bool:
        """True if the drive goes to a target by itself; if not, moves are streams that the daemon makes."""

    def _check_there(self) -> None:
        if not self.drive.link.is_there:
            raise VerbRefused("not_now", f"{self.drive.name} is not there: {self.drive.link.why}")

    async def _until(self, is_so: Callable[[], bool], what: str) -> None:
        """Wait until the drive tells that something is so. Raises VerbRefused: it does not."""
        drive, told_ns = self.drive, self.drive.now_ns()
        for _ in range(round(TAKES_S / _STATE_LOOK_S) + LOST_AFTER):
            reading = drive.reading
            if reading and reading.at_ns > told_ns and is_so():
                return
            if not drive.link.is_there:
                raise VerbRefused("not_now", f"{drive.name} was lost meanwhile: {drive.link.why}")
            await asyncio.sleep(_STATE_LOOK_S)
        said = f"; {drive.fault}" if drive.fault else ""
        raise VerbRefused(
            "not_now", f"{drive.name} was told so, and after {TAKES_S:g} s it is not {what}{said}"
        )

    # ---- verbs, by their names ----

    async def _stop(self) -> dict[str, float]:
        await self.motion.stop("prejudice")
        return {}

    async def _move_rel(self, angle_deg: float, **ramps: float) -> dict[str, float]:
        from_deg = self.motion.target_deg
        if from_deg is None:
            from_deg = self.axis.now().position_deg
        return await self._move_abs(from_deg + angle_deg, **ramps)

    async def _move_abs(
        self,
        position_deg: float,
        velocity_rpm: float | None = None,
        acceleration_rpm_per_s: float | None = None,
    ) -> dict[str, float]:
        drive, motion = self.drive, self.motion
        if drive.fault:
            raise VerbRefused("not_now", f"{drive.fault}; clear it first")
        if not drive.is_on:
            raise VerbRefused("not_now", "its loop is off; enable it first")
        now_ns = drive.now_ns()
        if self.has_own_ramps:
            motion.move(position_deg, velocity_rpm, acceleration_rpm_per_s, now_ns)
            while motion.is_waiting:
                await asyncio.sleep(_STATE_LOOK_S / 10)
            if motion.failure:
                raise VerbRefused("not_now", motion.failure)
            return {"set_point": position_deg}
        velocity_rpm, acceleration_rpm_per_s = (
            velocity_rpm or FOLLOW_RPM,
            acceleration_rpm_per_s or FOLLOW_RPM_PER_S,
        )
        here_deg, start_ns = self.axis.now().position_deg, now_ns + BEGIN_NS
        per_s, per_s2 = velocity_rpm * DEG_PER_S, acceleration_rpm_per_s * DEG_PER_S
        path = trapezoid(here_deg, 0.0, position_deg, per_s, per_s2)
        motion.check(position_deg)
        motion.follow(path, start_ns)
        return {"set_point": position_deg, "ends_after_ns": BEGIN_NS + length_ns(path)}
