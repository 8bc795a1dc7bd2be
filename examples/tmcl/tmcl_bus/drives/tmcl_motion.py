"""Motion of a real TMCL module, by its own ramps."""

import asyncio

from hil.drives.drive_motion import DriveMotion
from hil.drives.real_drive import SentSetPoint
from hil.vocab.axis import How
from hil.vocab.path import Path
from hil.vocab.verbs import VerbRefused
from tmcl_bus.drives.tmcl_drive import MOST_ACCELERATION, MOST_SPEED, TmclDrive
from tmcl_bus.frames import Command, Move

_MOST = 2**31 - 1


class TmclMotion(DriveMotion):
    """Motion of one module, the last that it was given."""

    def __init__(self, drive: TmclDrive) -> None:
        super().__init__(drive)
        self._drive = drive

    def check(self, *angles_deg: float) -> None:
        for angle_deg in angles_deg:
            if abs(angle_deg) / self._drive.step_deg > _MOST:
                raise VerbRefused("bad_parameter", f"position_deg: {angle_deg:g} deg are too many microsteps")

    def follow(self, path: Path, start_ns: int) -> None:
        raise VerbRefused("cannot", "a TMCL module follows no paths")

    async def stop(self, how: How = "grace", acceleration_rpm_per_s: float | None = None) -> None:
        self.abandon()
        self._drive.sent = None
        await self._drive.tell(Command.MST, 0, 0, self._drive.link.session)

    async def end(self) -> None:
        """Do nothing: it follows no set-points."""

    async def _send(
        self,
        position_deg: float,
        velocity_rpm: float | None,
        acceleration_rpm_per_s: float | None,
        start_ns: int,
        session: int,
    ) -> None:
        drive = self._drive
        for number, rpm in ((MOST_SPEED, velocity_rpm), (MOST_ACCELERATION, acceleration_rpm_per_s)):
            if not rpm:
                continue
            await drive.tell(Command.SAP, number, max(round(rpm / 60 * drive.per_turn), 1), session)
        await asyncio.sleep(max(start_ns - drive.now_ns(), 0) / 1e9)
        await drive.tell(Command.MVP, Move.ABS, round(position_deg / drive.step_deg), session)
        drive.sent = SentSetPoint(position_deg, drive.now_ns())
        self._await_end(position_deg)
        self._begins_ns = None
