"""Store of boards' memories as the bench sees it: commits go to files, answers come back as inputs."""

import asyncio
import logging
from collections.abc import Callable, Mapping
from contextlib import suppress

from hil.firmware.nvm import Content
from hil.live.store import NvmStore
from hil.sim.bench import Store
from hil.sim.twin import Twin

log = logging.getLogger("hil")


class Commits:
    """Boards' memories in files; answers come back as inputs, with times of their own. ``begin`` comes before
    a device's first commit."""

    def __init__(self, files: NvmStore, loop: asyncio.AbstractEventLoop) -> None:
        self._files = files
        self._loop = loop
        self._counters: dict[str, int] = {}
        self._ends = False
        self.failures: dict[str, str] = {}
        """Reasons why devices' memories were not written the last time, by device."""
        self.writes = {"ok": 0, "failed": 0}
        self.replayed: Store | None = None
        """Store that has the answers of a run that is gone through again."""

    def begin(self, device: str, counter: int) -> None:
        """Note that a device begins; ``counter``: number of the commits that made its file."""
        self._counters[device] = counter
        self.failures.pop(device, None)

    async def end(self) -> None:
        """Wait for the answers to all commits so far. Commits that boards begin on these answers are never
        answered themselves, as if the power went in the middle."""
        self._ends = True
        await self._loop.run_in_executor(None, self._files.close)

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        if self.replayed:
            return self.replayed.commit(device, sections, answered)
        if self._ends:
            return None
        self._counters[device.name] = self._counters.get(device.name, 0) + 1
        content = Content(device.profile, self._counters[device.name], dict(sections))

        def done(durable: bool, why: str) -> None:
            with suppress(RuntimeError):  # the loop is closed: the daemon has stopped
                self._loop.call_soon_threadsafe(self._done, device.name, durable, why, answered)

        self._files.commit(device.name, content, done)
        return None

    def _done(self, name: str, durable: bool, why: str, answered: Callable[[bool], bool]) -> None:
        self.writes["ok" if durable else "failed"] += 1
        if not answered(durable):
            return  # a reload has taken it away
        if durable:
            self.failures.pop(name, None)
        else:
            self.failures[name] = why
            log.error("%s: its flash was not written: %s; it keeps its old content", name, why)
