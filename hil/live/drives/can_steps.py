"""Steps of a real CANopen drive that a motion is made of: its controlword, its mode, its state machine."""

import asyncio
from collections.abc import Callable

from hil.drives.canopen.statusword import (
    ENABLE_OPERATION,
    MachineState,
    has_fault,
    state_of,
    towards_enabled,
)
from hil.live.drives.asking import Denied
from hil.live.drives.can_drive import CanDrive

TAKES_S = 1.0
"""Time for a drive to take a mode, a set-point, or a step of its state machine."""
POLL_S = 0.003
_CONTROLWORD, _STATUSWORD, _MODE, _MODE_DISPLAY = 0x6040, 0x6041, 0x6060, 0x6061


class CanSteps:
    """Steps of one drive. All raise ``ASKING``."""

    def __init__(self, drive: CanDrive) -> None:
        self._drive = drive

    async def walk(self, session: int) -> None:
        """Walk through the state machine until the loop is on."""
        drive, loop = self._drive, asyncio.get_running_loop()
        until_s = loop.time() + TAKES_S
        while (state := state_of(word := await drive.read(_STATUSWORD, session))) is not MachineState.ENABLED:
            if has_fault(word):
                raise Denied(f"{drive.fault or 'the drive has a fault'}; clear it first")
            if loop.time() > until_s:
                raise Denied(f"it stays in the state {state}")
            if (step := towards_enabled(state)) is not None:
                await self.control(step, session)
            await asyncio.sleep(POLL_S)
        await self.control(ENABLE_OPERATION, session)  # without a halt from before

    async def set_mode(self, mode: int, session: int) -> None:
        """Set the mode of operation, and wait until it is."""
        drive, loop = self._drive, asyncio.get_running_loop()
        await drive.write(_MODE, mode, 1, session)
        until_s = loop.time() + TAKES_S
        while await drive.read(_MODE_DISPLAY, session, is_signed=True) != mode:
            if loop.time() > until_s:
                raise Denied(f"it does not take the mode of operation {mode} (6060h)")
            await asyncio.sleep(POLL_S)

    async def control(self, word: int, session: int) -> None:
        """Write the controlword."""
        await self._drive.write(_CONTROLWORD, word, 2, session)

    async def until(self, is_so: Callable[[int], bool], else_why: str, session: int) -> None:
        """Wait until something is so of the statusword; ``else_why``: what is said if it does not come."""
        drive, loop = self._drive, asyncio.get_running_loop()
        until_s = loop.time() + TAKES_S
        while not is_so(await drive.read(_STATUSWORD, session)):
            if loop.time() > until_s:
                raise Denied(f"{else_why} within {TAKES_S:g} s")
            await asyncio.sleep(POLL_S)

    async def statusword(self, session: int) -> int:
        """Read the statusword."""
        return await self._drive.read(_STATUSWORD, session)
