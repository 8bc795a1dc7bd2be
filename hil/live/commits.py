"""The boards' store as the bench sees it: commits go to files, answers come back as inputs."""

import asyncio
import logging
from collections.abc import Mapping
from contextlib import suppress

from hil.firmware.nvm import Content
from hil.live.store import NvmStore
from hil.sim.bench import BenchRuntime
from hil.sim.device import Device
from hil.sim.inputs import CommitDone

log = logging.getLogger("hil")


class Commits:
    """Boards' memories in files; answers come back as inputs, with the times of their own. ``begin`` comes
    before a device's first commit."""

    def __init__(self, files: NvmStore, loop: asyncio.AbstractEventLoop) -> None:
        self._files = files
        self._loop = loop
        self.bench: BenchRuntime | None = None
        self._counters: dict[str, int] = {}
        self._ends = False
        self.failures: dict[str, str] = {}
        """Why a device's memory was not written the last time."""
        self.writes = {"ok": 0, "failed": 0}

    def begin(self, device: str, counter: int) -> None:
        """A device begins; ``counter``: of the commits that made its file."""
        self._counters[device] = counter
        self.failures.pop(device, None)

    async def end(self) -> None:
        """Wait for the answers to all commits so far. What they make the boards commit is never answered, as
        when their power goes in the middle of it."""
        self._ends = True
        await self._loop.run_in_executor(None, self._files.close)

    def commit(self, device: Device, sections: Mapping[str, bytes]) -> None:
        if self._ends:
            return
        self._counters[device.name] = self._counters.get(device.name, 0) + 1
        content = Content(device.profile, self._counters[device.name], dict(sections))
        self._files.commit(device.name, content, lambda ok, why: self._call_soon(device, ok, why))

    def _call_soon(self, device: Device, durable: bool, why: str) -> None:
        with suppress(RuntimeError):  # the loop is closed: the daemon has stopped
            self._loop.call_soon_threadsafe(self._done, device, durable, why)

    def _done(self, device: Device, durable: bool, why: str) -> None:
        self.writes["ok" if durable else "failed"] += 1
        if self.bench is None or self.bench.devices.get(device.name) is not device:
            return  # a reload has taken it away
        if durable:
            self.failures.pop(device.name, None)
        else:
            self.failures[device.name] = why
            log.error("%s: its flash was not written: %s; it keeps its old content", device.name, why)
        self.bench.give(device, CommitDone(durable))
