"""Verbs of a real Modbus drive, and its parameters."""

from bridges.modbus.drives.drive_lines import DriveLines
from bridges.modbus.drives.drive_polls import DrivePolls
from bridges.modbus.drives.register_drive import RegisterDrive
from bridges.modbus.drives.register_motion import RegisterMotion
from hil.drives.drive_axis import DriveAxis
from hil.drives.drive_control import DriveControl
from hil.drives.drive_link import URGENT, SharedLines


class RegisterControl(DriveControl):
    """Control of one drive."""

    motion_type: type[RegisterMotion] = RegisterMotion
    """Kind of its motion."""

    def __init__(self, drive: RegisterDrive) -> None:
        self._registers, self._motion_of = drive, self.motion_type(drive)
        super().__init__(DriveAxis(drive, self._motion_of))

    def begin(self, lines: SharedLines) -> None:
        drive, of_bench = self._registers, lines.of(DriveLines)
        drive.start(
            lambda member: of_bench.join(member, drive.place, drive.pace.timeout_s), DrivePolls(drive).run()
        )

    async def end(self, lines: SharedLines) -> None:
        await self._registers.close(lines.of(DriveLines).leave)

    @property
    def has_own_ramps(self) -> bool:
        return "start" in self._registers.map.control

    async def _write_parameter(self, name: str, value: float) -> None:
        await self._registers.write_value(name, value, self.drive.link.session, URGENT)

    # ---- verbs, by their names ----

    async def _enable(self) -> dict[str, float]:
        self.motion.abandon()
        session = self.drive.link.session
        if not self.drive.is_on:  # a drive may wait for the edge, as after a fault
            await self._registers.write_bits(session, enable=False)
        await self._registers.write_bits(session, enable=True, start=False, stop=False, follow=False)
        await self._until(lambda: self.drive.is_on, "enabled")
        return {}

    async def _disable(self) -> dict[str, float]:
        session = self.drive.link.session
        await self._registers.write_bits(session, URGENT, enable=False, start=False, follow=False)
        await self._until(lambda: not self.drive.is_on, "disabled")
        return {}

    async def _clear_fault(self) -> dict[str, float]:
        return await self._reset()

    async def _reset(self) -> dict[str, float]:
        await self._motion_of.reset()
        await self._until(lambda: self.drive.fault is None, "free of its fault")
        return {}
