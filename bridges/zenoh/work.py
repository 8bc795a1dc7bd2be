"""Work on answers that take their time."""

import asyncio
import logging
from collections.abc import Coroutine
from typing import Any

log = logging.getLogger("hil")

LATER = 1_000
"""Maximum number of queries that wait for a motion's end."""


class Work:
    """Tasks in the loop, until ``close``."""

    def __init__(self) -> None:
        self._working: set[asyncio.Task[None]] = set()
        self._waiting: dict[asyncio.Task[None], None] = {}
        """Tasks that wait for a motion's end, the oldest first."""

    @property
    def waiting(self) -> int:
        """Number of tasks that wait for a motion's end."""
        return len(self._waiting)

    def begin(self, working: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        task = asyncio.get_running_loop().create_task(working)
        self._working.add(task)
        task.add_done_callback(self._worked)
        return task

    def _worked(self, task: asyncio.Task[None]) -> None:
        self._working.discard(task)
        self._waiting.pop(task, None)
        if not task.cancelled() and (error := task.exception()):
            log.error("zenoh: an answer could not be made", exc_info=error)

    def await_end(self, waiting: Coroutine[Any, Any, None]) -> None:
        """Await a motion's end. Of too many the longest waiting gives way: its asker may be gone."""
        if len(self._waiting) >= LATER:
            oldest = next(iter(self._waiting))
            del self._waiting[oldest]
            self._working.add(oldest)
            oldest.cancel()
        task = asyncio.get_running_loop().create_task(waiting)
        self._waiting[task] = None
        task.add_done_callback(self._worked)

    async def close(self) -> None:
        under_way = [*self._waiting, *self._working]
        for task in under_way:
            task.cancel()
        await asyncio.gather(*under_way, return_exceptions=True)
