"""A real drive of a bench without the bench: with a clock, in an event loop."""

import asyncio
import gc
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

from foreign_drives import drive_map

from bridges.can.address.can_drive_address import CanDriveAddress, CanPlace
from bridges.modbus.registers.drive_map import DriveMap
from hil.live.drives.can_control import CanControl
from hil.live.drives.can_drive import CanDrive, CanSpec
from hil.live.drives.drive_control import DriveControl
from hil.live.drives.real_drive import DrivePace
from hil.live.drives.register_control import RegisterControl
from hil.live.drives.register_drive import RegisterDrive, RegisterSpec
from hil.live.drives.shared_lines import SharedLines
from hil.wire.drive_address import drive_address

PATIENCE_S = 10.0


class DriveWorld:
    """Drives, by name, and the clock that they go by."""

    def __init__(self) -> None:
        self.drives: dict[str, DriveControl] = {}
        self._lines = SharedLines()
        self._start_ns = time.monotonic_ns()

    @property
    def now_ns(self) -> int:
        return time.monotonic_ns() - self._start_ns

    def add(self, name: str, at: str, *, map: DriveMap | None = None, timeout_s: float = 0.2) -> DriveControl:
        pace = DrivePace(0.01, timeout_s, 0.02)
        spec = RegisterSpec(name, drive_address(at), map or drive_map(), pace)
        control = self.drives[name] = RegisterControl(RegisterDrive(spec, lambda: self.now_ns))
        control.begin(self._lines)
        return control

    def add_can(
        self, name: str, place: CanPlace, node: int, master: int | None = None, timeout_s: float = 0.2
    ) -> DriveControl:
        spec = CanSpec(name, CanDriveAddress(place, node, master), DrivePace(0.01, timeout_s, 0.01))
        control = self.drives[name] = CanControl(CanDrive(spec, lambda: self.now_ns))
        control.begin(self._lines)
        return control

    async def until(self, is_so: Callable[[], Any], what: str) -> None:
        deadline_s = time.monotonic() + PATIENCE_S
        while not is_so():
            links = {name: each.drive.link for name, each in self.drives.items()}
            assert time.monotonic() < deadline_s, f"{what}; {links}"
            await asyncio.sleep(0.002)

    async def close(self) -> None:
        while self.drives:
            await self.end(self.drives.popitem()[1])

    async def end(self, control: DriveControl) -> None:
        await control.axis.end()
        await control.end(self._lines)

    async def there(self, control: DriveControl) -> DriveControl:
        await self.until(lambda: control.drive.link.is_there, f"{control.drive.name} is there")
        return control


def in_drive_world(doing: Callable[[DriveWorld], Awaitable[None]]) -> None:
    """Run a test in an event loop whose turns are watched: none may take long."""

    async def run() -> None:
        loop, world = asyncio.get_running_loop(), DriveWorld()
        late_s, busy_s = [0.0], [0.0]

        async def beat() -> None:
            while True:
                due_s, used_s = loop.time() + 0.005, time.thread_time()
                await asyncio.sleep(0.005)
                late_s.append(loop.time() - due_s)
                busy_s.append(time.thread_time() - used_s)

        beating = loop.create_task(beat())
        try:
            await doing(world)
        finally:
            await world.close()
            beating.cancel()
            with suppress(asyncio.CancelledError):
                await beating
        # What other programs take of the computer is not this one's work; a call that waits would be.
        assert max(busy_s) < 0.15, "the event loop was held up by work"
        assert sorted(late_s)[-3:][0] < 0.5, "the event loop was held up by waits"

    gc.collect()
    gc.freeze()  # a look for garbage among all of a test run's objects is no work of the loop
    try:
        asyncio.run(run())
    finally:
        gc.unfreeze()
