"""A real drive of a bench without the bench: with a clock, in an event loop."""

import asyncio
import gc
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any, TypeVar

from hil.drives.drive_control import DriveControl
from hil.drives.drive_link import SharedLines

PATIENCE_S = 60.0


World = TypeVar("World", bound="DriveWorld")


class DriveWorld:
    """Drives, by name, and the clock that they go by."""

    def __init__(self) -> None:
        self.drives: dict[str, DriveControl] = {}
        self._lines = SharedLines()
        self._start_ns = time.monotonic_ns()

    @property
    def now_ns(self) -> int:
        return time.monotonic_ns() - self._start_ns

    def begin(self, name: str, control: DriveControl) -> DriveControl:
        self.drives[name] = control
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


def in_drive_world(make: Callable[[], World], doing: Callable[[World], Awaitable[None]]) -> None:
    """Run a test in an event loop whose turns are watched: none may take long."""

    async def run() -> None:
        loop, world = asyncio.get_running_loop(), make()
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
