"""Real drives of a bench, by their devices' names, and as runs find them."""

from collections.abc import Mapping
from dataclasses import replace

from hil.drives.canopen.greeting import sync_period_ns
from hil.live.configured import Configured
from hil.live.drives.can_drive import CanDrive
from hil.live.drives.can_line import CanLines
from hil.live.drives.can_session import CanSession
from hil.live.drives.drive_control import DriveControl
from hil.live.drives.drive_lines import DriveLines
from hil.live.drives.drive_polls import DrivePolls
from hil.live.drives.register_drive import RegisterDrive
from hil.vocab.axis import Axis, AxisNow


class Drives(dict[str, DriveControl]):
    """Drives by name. Only ``hil.live.apply`` changes them."""

    def __init__(self) -> None:
        super().__init__()
        self._lines, self._buses = DriveLines(), CanLines()

    def begin(self, name: str) -> None:
        """Begin to ask a drive."""
        drive = self[name].drive
        if isinstance(drive, RegisterDrive):
            place, timeout_s = drive.place, drive.pace.timeout_s
            drive.start(lambda member: self._lines.join(member, place, timeout_s), DrivePolls(drive).run())
        elif isinstance(drive, CanDrive):
            bus, sync_ns = drive.spec.address.place, sync_period_ns(round(drive.pace.setpoint_s * 1e9))
            drive.start(lambda member: self._buses.join(member, bus, sync_ns), CanSession(drive).run())

    async def end(self, control: DriveControl) -> None:
        """Stop a drive that moves, and ask it no more."""
        await control.axis.end()
        if isinstance(control.drive, RegisterDrive):
            await control.drive.close(self._lines.leave)
        elif isinstance(control.drive, CanDrive):
            await control.drive.close(self._buses.leave)

    async def close(self) -> None:
        """Stop all that move, and ask nobody any more."""
        while self:
            await self.end(self.popitem()[1])


class DriveAxes:
    """Axes of the drives of a bench."""

    def __init__(self, drives: Mapping[str, DriveControl], configured: Configured) -> None:
        self._drives = drives
        self._configured = configured

    def __contains__(self, name: str) -> bool:
        return name in self._drives

    def axes(self) -> dict[str, AxisNow]:
        found = {name: control.axis.now() for name, control in self._drives.items()}
        if (speed := self._configured.config.speed) != 1:
            why = f"the bench goes at {speed:g} times the speed of its real drives"
            return {name: replace(now, why_not=why) for name, now in found.items()}
        return found

    def __getitem__(self, name: str) -> Axis:
        return self._drives[name].axis
