"""Readings that all pages share: fifty pages cost the bench no more than one."""

import asyncio
import logging
from collections.abc import Sequence
from inspect import isawaitable

from hil.net.fair_share import SHARE
from hil.vocab.desk_protocol import Desk, Encoded, Source
from hil.wire.json_text import json_text

log = logging.getLogger("hil")

SHORTEST_S = 0.2
"""Minimum time between two readings. One that takes long is made less often: its share of the loop is as
small as that of requests."""
FAILED_S = 10.0
"""Time until a reading is made again that met a fault of hil's own: the log has it each time."""
OLDEST_S = 0.5
"""Age from which the answer before is not told while the next one is being made: two turns of pages."""


class SharedReading:
    """Answer of an operation without a target, as JSON."""

    def __init__(self, desk: Desk, source: Source, operation: str) -> None:
        self._desk, self._source, self._operation = desk, source, operation
        self._begun_s = self._due_s = float("-inf")
        self._reading: asyncio.Future[object] | None = None
        self._turn = 0
        self._parts: Sequence[bytes] = ()

    @property
    def is_under_way(self) -> bool:
        """True while it is being made."""
        return self._reading is not None

    def read(self, now_s: float) -> tuple[int, Sequence[bytes]] | None:
        """Answer, and a number that is another one when the answer is. None: it is being made, and the one
        before is old. It is made again where it is due."""
        if self._reading is None and now_s >= self._due_s:
            answer = self._desk.ask(self._source, self._operation, "", {})
            if isawaitable(answer):
                self._reading = asyncio.ensure_future(answer)
                self._reading.add_done_callback(lambda done: self._made(done, now_s))
            else:
                self._take(answer, now_s)
        return (self._turn, self._parts) if not self._reading or now_s - self._begun_s <= OLDEST_S else None

    def _made(self, done: "asyncio.Future[object]", begun_s: float) -> None:
        self._reading = None
        if done.cancelled():
            return
        if error := done.exception():
            log.error("bridges.web: %s could not be read", self._operation, exc_info=error)
            self._due_s = begun_s + FAILED_S
        else:
            self._take(done.result(), begun_s)

    def _take(self, answer: object, begun_s: float) -> None:
        parts = answer.parts if isinstance(answer, Encoded) else (json_text(answer).encode(),)
        if parts != self._parts:
            self._turn, self._parts = self._turn + 1, parts
        now_s = asyncio.get_running_loop().time()
        self._begun_s, self._due_s = begun_s, begun_s + max(SHORTEST_S, (now_s - begun_s) / SHARE)

    def close(self) -> None:
        if self._reading:
            self._reading.cancel()
