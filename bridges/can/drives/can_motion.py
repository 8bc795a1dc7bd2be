"""Motion of a real CANopen drive: by its own ramps (profile position), or by a set-point with each SYNC
(cyclic synchronous position)."""

import asyncio
from contextlib import suppress

from bridges.can.canopen.cia402_words import (
    CHANGE_AT_ONCE,
    CYCLIC_POSITION,
    HOMING,
    HOMING_ATTAINED,
    HOMING_ERROR,
    NEW_SET_POINT,
    PROFILE_POSITION,
    SET_POINT_TAKEN,
    TARGET_POSITION,
    TARGET_REACHED,
    DriveCommand,
    DriveState,
    state_of,
)
from bridges.can.drives.can_drive import CanDrive
from bridges.can.drives.can_steps import STATE_LOOK_S, CanSteps
from bridges.can.drives.sdo_dialogue import Aborted
from hil.drives.drive_link import ASKING, Denied, Stale
from hil.drives.drive_motion import DriveMotion
from hil.drives.real_drive import SentSetPoint
from hil.firmware.set_point_paths import at, length_ns
from hil.vocab.axis import How
from hil.vocab.path import Path
from hil.vocab.verbs import VerbRefused

HOMING_POLL_S, SHOWS_S = 0.05, 0.2
HOMING_DONE = HOMING_ATTAINED | TARGET_REACHED
"""Bits of the statusword in homing: it was attained and the drive stands. CiA 402-2, 9.3."""
_BY_PROFILE, _BY_QUICK_STOP = 5, 6
"""Quick stop options (605Ah): by the ramp of the profile or of the quick stop, and the loop stays on."""
_QUICK_STOP_OPTION, _HOMING_METHOD = 0x605A, 0x6098
_VELOCITY, _ACCELERATION, _DECELERATION = 0x6081, 0x6083, 0x6084


class CanMotion(DriveMotion):
    """Motion of one drive, the last that it was given."""

    def __init__(self, drive: CanDrive) -> None:
        super().__init__(drive)
        self._drive, self._steps = drive, CanSteps(drive)

    # ---- what it is given ----

    def check(self, *angles_deg: float) -> None:
        if (known := self._drive.known) is None:
            return
        for angle_deg in angles_deg:
            try:
                known.units.position(angle_deg)
            except (ValueError, OverflowError) as error:
                raise VerbRefused("bad_parameter", f"position_deg: {error}") from None

    async def stop(self, how: How = "grace", acceleration_rpm_per_s: float | None = None) -> None:
        """Stop the drive: a stream with its last set-points, all else by the drive's quick stop.

        Raises:
            ASKING: that was not confirmed.
        """
        streamed, drive = self._path, self._drive
        self.abandon()
        if streamed and how == "grace" and acceleration_rpm_per_s:
            self._run_down(streamed, acceleration_rpm_per_s)
        elif drive.is_on:
            await self._quick_stop(_BY_PROFILE if how == "grace" else _BY_QUICK_STOP, drive.link.session)

    async def end(self) -> None:
        """Let a drive that stands follow no set-points any more."""
        drive = self._drive
        if self.is_under_way or not drive.link.is_there or drive.set_points is None:
            return
        with suppress(*ASKING):
            await self._hold(drive.link.session)

    async def home(self, method: int | None) -> None:
        """Begin to find the origin, which is a motion without a target. Raises ``ASKING``."""
        self.abandon()
        drive, session = self._drive, self._drive.link.session
        await self._steps.control(DriveCommand.ENABLE, session)
        await self._steps.set_mode(HOMING, session)
        drive.set_points = drive.sent = None
        if method is not None:
            await drive.write(_HOMING_METHOD, method, 1, session)
        await self._steps.control(DriveCommand.ENABLE | NEW_SET_POINT, session)
        self._begin(self._until_home(session))
        self._begins_ns = drive.now_ns()

    # ---- verbs that are no motions ----

    async def enable(self) -> None:
        """Switch the loop on. Raises ``ASKING``."""
        self.abandon()
        session = self._drive.link.session
        await self._hold(session)
        await self._steps.walk(session)

    async def disable(self) -> None:
        """Switch the loop off. Raises ``ASKING``."""
        self.abandon()
        await self._steps.control(DriveCommand.SHUTDOWN, self._drive.link.session)
        self._drive.set_points = None

    async def clear_fault(self) -> None:
        """Clear a fault. Raises ``ASKING``."""
        self.abandon()
        session = self._drive.link.session
        self._drive.set_points = None
        await self._steps.reset_fault(session)

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
        assert drive.known is not None, "a drive that is there was greeted"
        units = drive.known.units
        await self._steps.set_mode(PROFILE_POSITION, session)
        drive.set_points = None
        if velocity_rpm:
            await drive.write(_VELOCITY, units.velocity(velocity_rpm), 4, session)
        if acceleration_rpm_per_s:
            for index in (_ACCELERATION, _DECELERATION):
                await drive.write(index, units.acceleration(acceleration_rpm_per_s), 4, session)
        await drive.write(TARGET_POSITION, units.position(position_deg), 4, session)
        await self._steps.control(DriveCommand.ENABLE, session)
        await asyncio.sleep(max(start_ns - drive.now_ns(), 0) / 1e9)
        await self._steps.control(DriveCommand.ENABLE | NEW_SET_POINT | CHANGE_AT_ONCE, session)
        await self._steps.until(
            lambda word: bool(word & SET_POINT_TAKEN), "it did not take the set-point", session
        )
        await self._steps.control(DriveCommand.ENABLE, session)
        drive.sent = SentSetPoint(position_deg, drive.now_ns())
        self._await_end(position_deg)
        self._begins_ns = None

    async def _stream(self, path: Path, start_ns: int, session: int) -> None:
        drive = self._drive
        end_ns = start_ns + length_ns(path)
        drive.set_points = lambda at_ns: at(path, at_ns - start_ns)[0]
        if drive.reading and drive.reading.values["mode"] != CYCLIC_POSITION:
            assert drive.known is not None, "a drive that is there was greeted"
            first = drive.known.units.position(at(path, drive.now_ns() - start_ns)[0])
            await drive.write(TARGET_POSITION, first, 4, session)  # also before the first SYNC
            await self._steps.set_mode(CYCLIC_POSITION, session)
        await self._steps.control(DriveCommand.ENABLE, session)
        while drive.now_ns() <= end_ns + 2 * drive.line.sync_ns:
            if not drive.is_in(session):
                raise Stale("the drive was lost")
            await asyncio.sleep(min(max(end_ns - drive.now_ns(), 0) / 1e9 + STATE_LOOK_S, 0.1))
        self._await_end(path[-1].r)
        self._path = None

    async def _until_home(self, session: int) -> None:
        """Wait for the end of homing: bits 10 and 12 say that it is done, bit 13 that it failed."""
        await asyncio.sleep(SHOWS_S)  # what it tells at first may be of the last time
        while True:
            word = await self._steps.statusword(session)
            if word & HOMING_ERROR:
                raise Denied(f"its homing failed (statusword {word:04X}h)")
            if state_of(word) is not DriveState.OPERATION_ENABLED:
                raise Denied("its loop was switched off as it looked for its origin")
            if word & HOMING_DONE == HOMING_DONE:
                break
            await asyncio.sleep(HOMING_POLL_S)
        await self._hold(session)
        self._begins_ns = None

    async def _quick_stop(self, option: int, session: int) -> None:
        """Stop, and hold the shaft there with the loop on."""
        drive = self._drive
        drive.is_stopping = True
        try:
            try:
                await drive.write(_QUICK_STOP_OPTION, option, 2, session)
                await self._steps.control(DriveCommand.QUICK_STOP, session)
                await self._steps.until_it_stands(session)
            except Aborted:  # its quick stop is fixed, and may take the current off
                await self._steps.halt(session)
            await self._hold(session)
            await self._steps.walk(session)
        finally:
            drive.is_stopping = False

    async def _hold(self, session: int) -> None:
        """Let the drive hold its shaft by itself; one that only follows is given where it is."""
        drive = self._drive
        assert drive.known is not None, "a drive that is there was greeted"
        if drive.known.has_mode(PROFILE_POSITION):
            await self._steps.set_mode(PROFILE_POSITION, session)
            drive.set_points = None
            return
        here_deg = drive.position_deg or 0.0
        drive.set_points = lambda at_ns: here_deg
        await self._steps.set_mode(CYCLIC_POSITION, session)
