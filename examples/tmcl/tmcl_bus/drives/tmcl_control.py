"""Verbs of a real TMCL module."""

from hil.drives.drive_axis import DriveAxis
from hil.drives.drive_control import DriveControl
from hil.drives.drive_link import SharedLines
from tmcl_bus.drives.tmcl_drive import TmclDrive
from tmcl_bus.drives.tmcl_line import TmclLines
from tmcl_bus.drives.tmcl_motion import TmclMotion


class TmclControl(DriveControl):
    """Control of one module."""

    has_own_ramps = True

    def __init__(self, drive: TmclDrive) -> None:
        self._module = drive
        super().__init__(DriveAxis(drive, TmclMotion(drive)))

    def begin(self, lines: SharedLines) -> None:
        self._module.start(lines.of(TmclLines))

    async def end(self, lines: SharedLines) -> None:
        await self._module.close(lines.of(TmclLines))

    async def _write_parameter(self, name: str, value: float) -> None:
        raise AssertionError("a TMCL module has no parameters that can be set")
