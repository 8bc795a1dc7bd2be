"""Verbs of a real CANopen drive."""

import asyncio

from bridges.can.canopen.canopen_codes import NmtCommand
from bridges.can.canopen.cia402_words import HOMING, PROFILE_POSITION
from bridges.can.canopen.master.greeting import sync_period_ns
from bridges.can.drives.can_drive import CanDrive
from bridges.can.drives.can_line import CanLines
from bridges.can.drives.can_motion import CanMotion
from bridges.can.drives.can_session import CanSession
from hil.drives.drive_axis import DriveAxis
from hil.drives.drive_control import DriveControl
from hil.drives.drive_link import SharedLines
from hil.vocab.verbs import VerbRefused

STARTS_S = 10.0
"""Time for a drive to start again, and to be greeted."""
_RESTART_LOOK_S = 0.02


class CanControl(DriveControl):
    """Control of one drive."""

    def __init__(self, drive: CanDrive) -> None:
        self._can, self._motion_of = drive, CanMotion(drive)
        super().__init__(DriveAxis(drive, self._motion_of))

    def begin(self, lines: SharedLines) -> None:
        drive, of_bench = self._can, lines.of(CanLines)
        sync_ns = sync_period_ns(round(drive.pace.setpoint_s * 1e9))
        drive.start(
            lambda member: of_bench.join(member, drive.spec.address.place, sync_ns), CanSession(drive).run()
        )

    async def end(self, lines: SharedLines) -> None:
        await self._can.close(lines.of(CanLines).leave)

    @property
    def has_own_ramps(self) -> bool:
        return self._can.known is not None and self._can.known.has_mode(PROFILE_POSITION)

    async def _write_parameter(self, name: str, value: float) -> None:
        raise AssertionError("a CANopen drive has no parameters that can be set")

    # ---- verbs, by their names ----

    async def _enable(self) -> dict[str, float]:
        if self.drive.fault:
            raise VerbRefused("not_now", f"{self.drive.fault}; clear it first")
        await self._motion_of.enable()
        await self._until(lambda: self.drive.is_on, "enabled")
        return {}

    async def _disable(self) -> dict[str, float]:
        await self._motion_of.disable()
        await self._until(lambda: not self.drive.is_on, "disabled")
        return {}

    async def _home(self, method: float | None = None) -> dict[str, float]:
        drive = self._can
        if drive.fault:
            raise VerbRefused("not_now", f"{drive.fault}; clear it first")
        if not drive.is_on:
            raise VerbRefused("not_now", "its loop is off; enable it first")
        if drive.known and not drive.known.has_mode(HOMING):
            raise VerbRefused("cannot", "the drive has no homing (6502h)")
        await self._motion_of.home(None if method is None else int(method))
        return {}

    async def _clear_fault(self) -> dict[str, float]:
        await self._motion_of.clear_fault()
        await self._until(lambda: self.drive.fault is None, "free of its fault")
        return {}

    async def _reset(self) -> dict[str, float]:
        drive, session = self._can, self._can.link.session
        self.motion.abandon()
        drive.command(NmtCommand.RESET)
        for _ in range(round(STARTS_S / _RESTART_LOOK_S)):
            await asyncio.sleep(_RESTART_LOOK_S)
            if drive.link.is_there and drive.link.session != session:
                return {}
        raise VerbRefused(
            "not_now", f"{drive.name} was told to start again, and after {STARTS_S:g} s it is not there"
        )
