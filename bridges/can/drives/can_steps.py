"""Steps of a real CANopen drive that a motion is made of: its controlword, its mode, its state machine."""

import asyncio
from collections.abc import Callable

from bridges.can.canopen.cia402_words import (
    CHANGE_AT_ONCE,
    CONTROLWORD,
    HALT,
    MODE,
    MODE_DISPLAY,
    NEW_SET_POINT,
    STATUSWORD,
    TARGET_POSITION,
    DriveCommand,
    DriveState,
    has_fault,
    state_of,
    towards_enabled,
)
from bridges.can.drives.can_drive import CanDrive
from hil.drives.drive_link import Denied, Stale

STANDS_S = 20.0
"""Time for a drive to come to a stand."""
TAKES_S = 1.0
"""Time for a drive to take a mode, a set-point, or a step of its state machine."""
STATE_LOOK_S = 0.003


class CanSteps:
    """Steps of one drive. All raise ``ASKING``."""

    def __init__(self, drive: CanDrive) -> None:
        self._drive = drive

    async def walk(self, session: int) -> None:
        """Walk through the state machine until the loop is on."""
        drive, loop = self._drive, asyncio.get_running_loop()
        until_s = loop.time() + TAKES_S
        while True:
            state = state_of(word := await self.statusword(session))
            if state is DriveState.OPERATION_ENABLED:
                break
            if has_fault(word):
                raise Denied(f"{drive.fault or 'the drive has a fault'}; clear it first")
            if loop.time() > until_s:
                raise Denied(f"it stays in the state {state.about}")
            if (step := towards_enabled(state)) is not None:
                await self.control(step, session)
            await asyncio.sleep(STATE_LOOK_S)
        await self.control(DriveCommand.ENABLE, session)  # without a halt from before

    async def set_mode(self, mode: int, session: int) -> None:
        """Set the mode of operation, and wait until it is."""
        drive, loop = self._drive, asyncio.get_running_loop()
        await drive.write(MODE, mode, 1, session)
        until_s = loop.time() + TAKES_S
        while await drive.read(MODE_DISPLAY, session, is_signed=True) != mode:
            if loop.time() > until_s:
                raise Denied(f"it does not take the mode of operation {mode} (6060h)")
            await asyncio.sleep(STATE_LOOK_S)

    async def control(self, word: int, session: int) -> None:
        """Write the controlword."""
        await self._drive.write(CONTROLWORD, word, 2, session)

    async def until(self, is_so: Callable[[int], bool], else_why: str, session: int) -> None:
        """Wait until something is so of the statusword; ``else_why``: what is said if it does not come."""
        drive, loop = self._drive, asyncio.get_running_loop()
        until_s = loop.time() + TAKES_S
        while not is_so(await drive.read(STATUSWORD, session)):
            if loop.time() > until_s:
                raise Denied(f"{else_why} within {TAKES_S:g} s")
            await asyncio.sleep(STATE_LOOK_S)

    async def statusword(self, session: int) -> int:
        """Read the statusword."""
        return await self._drive.read(STATUSWORD, session)

    async def reset_fault(self, session: int) -> None:
        """Clear a fault: the edge of its bit counts."""
        for word in (DriveCommand.DISABLE_VOLTAGE, DriveCommand.RESET, DriveCommand.DISABLE_VOLTAGE):
            await self.control(word, session)
            await asyncio.sleep(STATE_LOOK_S)

    async def halt(self, session: int) -> None:
        """Halt, and take the rest of the motion away: a halt that ends goes on with it."""
        drive, halted = self._drive, DriveCommand.ENABLE | HALT
        await self.control(halted, session)
        await self.until_it_stands(session)
        if drive.known is not None:
            await drive.write(
                TARGET_POSITION, drive.known.units.position(drive.position_deg or 0.0), 4, session
            )
        await self.control(halted | NEW_SET_POINT | CHANGE_AT_ONCE, session)
        await asyncio.sleep(drive.pace.interval_s)
        await self.control(halted, session)

    async def until_it_stands(self, session: int) -> None:
        """Wait until the shaft stands."""
        drive = self._drive
        loop = asyncio.get_running_loop()
        told_ns, until_s = drive.now_ns(), loop.time() + STANDS_S
        while loop.time() < until_s:
            reading = drive.reading
            if reading and reading.at_ns > told_ns + 2 * drive.pace.interval_s * 1e9:
                state = state_of(int(reading.values["statusword"]))
                if not reading.bits["status.moving"] or state is DriveState.SWITCH_ON_DISABLED:
                    return
            if not drive.is_in(session):
                raise Stale("the drive was lost as it stopped")
            await asyncio.sleep(STATE_LOOK_S)
        raise Denied(f"it was told to stop, and after {STANDS_S:g} s it still moves")
