"""Operations that look back: the run of this bench at any time of it, from its recording."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

from hil.live.run_recording import RunRecording
from hil.operations.past_process import PastProcess
from hil.operations.table import Asked
from hil.vocab.desk_protocol import Encoded
from hil.vocab.time import NS_PER_S
from hil.vocab.verbs import VerbRefused

IDLE_S = 60.0
"""Time without a request after which the process that looks ends."""
WRITTEN_AFTER_S = 1.0
"""Time after which the recording has what happened, with room: it is written five times a second."""
MOST_WAITING = 16
"""Maximum number of requests that wait for answers."""


class PastOperations:
    """Operations on the recording of a bench. A process of low priority answers them, while somebody asks.
    ``now_ns``: simulated time, now."""

    def __init__(self, recording: RunRecording, now_ns: Callable[[], int], speed: float) -> None:
        self._recording, self._now_ns, self._speed = recording, now_ns, speed
        self._process: PastProcess | None = None
        self._asking = 0
        self._alone = 0
        self._timer: asyncio.TimerHandle | None = None
        self._leaving = set[asyncio.Future[None]]()

    def overview(self, asked: Asked, revision: int, most: float) -> Coroutine[Any, Any, Encoded]:
        """Length of the recording, and its marks unless the asker has them."""
        return self._ask({"what": "overview", "revision": revision, "most": int(most)}, "")

    def state(self, asked: Asked, at_s: float, lane: str) -> Coroutine[Any, Any, Encoded]:
        """All axes, and the faults, at a time."""
        return self._ask({"what": "state"} | _at(at_s), lane)

    def samples(
        self, asked: Asked, fields: list[str], from_s: float, to_s: float, points: float, lane: str
    ) -> Coroutine[Any, Any, Encoded]:
        """Samples of fields over a window."""
        if to_s < from_s:
            raise VerbRefused("bad_parameter", f"to_s: {to_s:g} is before from_s, {from_s:g}")
        window = {"from_ns": _ns(from_s), "to_ns": _ns(to_s)}
        return self._ask({"what": "samples", "fields": fields, "points": int(points)} | window, lane)

    def bytes_at(self, asked: Asked, port: str, at_s: float, lane: str) -> Coroutine[Any, Any, Encoded]:
        """Last bytes at a port before a time."""
        return self._ask({"what": "bytes", "of": port} | _at(at_s), lane)

    def packets(self, asked: Asked, wire: str, at_s: float, lane: str) -> Coroutine[Any, Any, Encoded]:
        """Last packets of a wire before a time."""
        return self._ask({"what": "packets", "of": wire} | _at(at_s), lane)

    def find(
        self, asked: Asked, condition: str, from_s: float, back: bool, lane: str
    ) -> Coroutine[Any, Any, Encoded]:
        """Time at which a condition begins to hold, of the next ones, or of those before."""
        return self._ask({"what": "find", "condition": condition, "back": back} | _at(from_s), lane)

    async def end(self) -> None:
        """End the process, if it runs."""
        if self._timer:
            self._timer.cancel()
        await self._leave()
        await asyncio.gather(*self._leaving)

    async def _leave(self) -> None:
        process, self._process = self._process, None
        if process:
            await process.end()

    async def _ask(self, request: dict[str, Any], lane: str) -> Encoded:
        if (file := self._recording.file) is None:
            why = self._recording.problem or "the bench was started with --no-log, or keeps no recordings"
            raise VerbRefused("not_now", f"this run is not recorded: {why}")
        if self._asking >= MOST_WAITING:
            raise VerbRefused("not_now", f"{self._asking} requests about the recording wait already")
        if self._process and self._process.is_over:
            await self._leave()
        if self._process is None:
            self._process = PastProcess(file.path)
        self._alone += 1
        known_ns = 0 if file.problem else self._now_ns() - round(WRITTEN_AFTER_S * self._speed * NS_PER_S)
        lane = f"{request['what']} {lane}" if lane else f"alone {self._alone}"
        self._asking += 1
        try:
            return Encoded(await self._process.ask({**request, "lane": lane, "known_ns": max(known_ns, 0)}))
        finally:
            self._asking -= 1
            self._await_silence()

    def _await_silence(self) -> None:
        if self._timer:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(IDLE_S, self._leave_soon)

    def _leave_soon(self) -> None:
        leaving = asyncio.ensure_future(self._leave())
        self._leaving.add(leaving)
        leaving.add_done_callback(self._leaving.discard)


def _ns(at_s: float) -> int:
    return round(at_s * NS_PER_S)


def _at(at_s: float) -> dict[str, int]:
    return {"from_ns": _ns(at_s), "to_ns": _ns(at_s)}
