"""Motion of a real Modbus drive, by its own ramps or by a stream of set-points."""

import asyncio
from contextlib import suppress

from bridges.modbus.drives.control_bits import value_write
from bridges.modbus.drives.register_drive import RegisterDrive
from hil.drives.drive_link import ASKING, URGENT, NoAnswer
from hil.drives.drive_motion import DriveMotion
from hil.firmware.set_point_paths import at, length_ns
from hil.vocab.axis import How
from hil.vocab.path import Path
from hil.vocab.verbs import VerbRefused

PULSE_S = 0.05
"""Time for which a bit that acts as it becomes 1 stays so: longer than a drive's own cycle."""
LATE_NS = 500_000_000
"""Time without a confirmed set-point after which a stream has failed."""


def ramps_of(velocity_rpm: float | None, acceleration_rpm_per_s: float | None) -> dict[str, float]:
    """Values that a move is given beside its angle."""
    ramps = {"set_velocity_rpm": velocity_rpm, "acceleration_rpm_per_s": acceleration_rpm_per_s}
    return {name: value for name, value in ramps.items() if value}


class RegisterMotion(DriveMotion):
    """Motion of one drive, the last that it was given."""

    def __init__(self, drive: RegisterDrive) -> None:
        super().__init__(drive)
        self._drive = drive

    # ---- what it is given ----

    def check(self, *angles_deg: float) -> None:
        """Check that its registers can hold set-points. Raises VerbRefused."""
        place = self._drive.map.values["set_point_deg"]
        for angle_deg in angles_deg:
            try:
                value_write(self._drive.map, place, angle_deg)
            except ValueError as error:
                raise VerbRefused("bad_parameter", f"set_point_deg: {error}") from None

    async def stop(self, how: How = "grace", acceleration_rpm_per_s: float | None = None) -> None:
        """Stop the drive: by its own bit, or with a stream's last set-points, or where it is.

        Raises:
            ASKING: that was not confirmed.
        """
        streamed = self._path
        self.abandon()
        drive = self._drive
        session = drive.link.session
        if "stop" in drive.map.control:
            await self._pulse("stop", session, URGENT, start=False, follow=False)
            return
        if streamed and how == "grace" and acceleration_rpm_per_s:
            self._run_down(streamed, acceleration_rpm_per_s)
            return
        here_deg = drive.position_deg
        if not streamed and here_deg is not None:
            await drive.write_value("set_point_deg", here_deg, session, URGENT)
            if "start" in drive.map.control:
                await self._pulse("start", session, URGENT)

    async def end(self) -> None:
        """Let a drive that stands follow no set-points any more."""
        drive = self._drive
        if not self.is_under_way and drive.link.is_there and "follow" in drive.map.control:
            with suppress(*ASKING):
                await drive.write_bits(drive.link.session, follow=False)

    # ---- how ----

    async def _send(
        self,
        position_deg: float,
        velocity_rpm: float | None,
        acceleration_rpm_per_s: float | None,
        start_ns: int,
        session: int,
    ) -> None:
        drive = self._drive
        for name, value in ramps_of(velocity_rpm, acceleration_rpm_per_s).items():
            if name in drive.map.values:
                await drive.write_value(name, value, session)
        await drive.write_bits(session, follow=False, start=False)
        await drive.write_value("set_point_deg", position_deg, session)
        await asyncio.sleep(max(start_ns - drive.now_ns(), 0) / 1e9)
        await drive.write_bits(session, URGENT, start=True)
        self._await_end(position_deg)
        self._begins_ns = None
        await asyncio.sleep(PULSE_S)
        await drive.write_bits(session, start=False)

    async def _pulse(self, bit: str, session: int, order: int, **others: bool) -> None:
        """Let a bit become 1, and 0 again."""
        await self._drive.write_bits(session, order, **{bit: True}, **others)
        await asyncio.sleep(PULSE_S)
        await self._drive.write_bits(session, order, **{bit: False})

    async def reset(self) -> None:
        """Clear the drive's fault. Raises ``ASKING``."""
        self.abandon()
        await self._pulse("reset", self._drive.link.session, URGENT)

    async def _stream(self, path: Path, start_ns: int, session: int) -> None:
        drive, now_ns = self._drive, self._drive.now_ns
        end_ns, period_ns = start_ns + length_ns(path), round(drive.pace.setpoint_s * 1e9)
        await drive.write_value("set_point_deg", at(path, now_ns() - start_ns)[0], session)
        await drive.write_bits(session, follow=True, start=False, stop=False)
        await asyncio.sleep(max(start_ns - now_ns(), 0) / 1e9)
        confirmed_ns = due_ns = now_ns()
        while True:
            # One that comes late is that of its own time, and none is sent twice to catch up.
            at_ns = min(now_ns(), end_ns)
            try:
                await drive.write_value("set_point_deg", at(path, at_ns - start_ns)[0], session, tries=1)
                confirmed_ns = now_ns()
                if at_ns >= end_ns:
                    break
            except NoAnswer:
                if now_ns() - confirmed_ns > LATE_NS:
                    raise
            due_ns = max(due_ns + period_ns, now_ns())
            await asyncio.sleep((min(due_ns, max(end_ns, now_ns())) - now_ns()) / 1e9)
        self._await_end(path[-1].r)
        self._path = None
