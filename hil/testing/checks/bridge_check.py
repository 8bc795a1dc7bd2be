"""Check of a bridge: ``hil.vocab.bridge_protocol.Bridge``."""

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import replace
from random import Random

from hil.testing.checks.bridge_client import ENDLESS_BYTES, STILL_S, Ask, BridgeClient, Status, connected
from hil.testing.checks.findings import CheckFailed, descriptors, raised, shown
from hil.testing.checks.recording_desk import RecordingDesk
from hil.testing.checks.running_checks import Before, LoopWatch, Wrong, findings_of, until, until_nothing_is
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.desk_protocol import Desk
from hil.vocab.verbs import VerbRefused

PATIENCE_S = 5.0
HELD_UP_S = 1.0
"""Maximum time for which a bridge may hold up the event loop that serves the ports; a good one takes ms."""
CLIENTS, CLIENTS_KEPT = 150, 100
STATUS = ("root", "listen", "connect", "links", "insecure")


def check_bridge(
    make: Callable[[Desk], Bridge],
    *,
    request: bytes | None = None,
    ask: Ask | None = None,
    desk: Callable[[], RecordingDesk] = RecordingDesk,
    patience_s: float = PATIENCE_S,
    only: str = "",
) -> None:
    """Check a bridge. ``make``: makes one for a desk, not yet open. ``request``: bytes that are answered at
    the first address that it listens at, over TCP; or ``ask``, which asks in another way. ``desk``: makes the
    desk of a bench with a twin ``m1`` and a real board ``m2``. ``patience_s``: time in which what has to
    happen does. ``only``: word of the one check to make beside ``time``, while a bridge is mended.

    - opened: ``status()`` has its fields, before and after ``open``, and they can be written as JSON.
    - answer: the request is answered.
    - chunking: it is, alike, when its bytes come one by one.
    - silence: where nobody asks, nothing is carried out.
    - garbage: whatever comes, nothing is carried out, and the next request is answered.
    - refusal: what the bench refuses does not end it.
    - devices: boards that are added, removed and exchanged do not.
    - reset: closed and made again, it answers as before.
    - replay: the same request has the same answer.
    - time: it never holds up the event loop.
    - limits: many clients at a time, and a request without an end, do not use up the computer.
    - left: ``close`` leaves no file descriptor, task, thread or watch.

    Raises:
        CheckFailed: with all that is wrong.
    """
    found = asyncio.run(_BridgeCheck(make, request, ask, desk, patience_s).findings(only))
    if found:
        raise CheckFailed("the bridge", found)


class _BridgeCheck:
    def __init__(
        self,
        make: Callable[[Desk], Bridge],
        request: bytes | None,
        ask: Ask | None,
        desk: Callable[[], RecordingDesk],
        patience_s: float,
    ) -> None:
        self._make, self._desk = make, desk
        self._has_request = request is not None
        self._client = BridgeClient(request, ask, patience_s)
        self._patience_s = patience_s

    async def findings(self, only: str) -> list[str]:
        checks: dict[str, Callable[[], Awaitable[None]]] = {
            "opened": self._opened,
            "answer": self._answer,
            "chunking": self._chunking,
            "silence": self._silence,
            "garbage": self._garbage,
            "refusal": self._refusal,
            "devices": self._devices,
            "reset": self._reset,
            "replay": self._replay,
            "limits": self._limits,
            "left": self._left,
        }
        if not self._has_request:
            del checks["chunking"], checks["limits"]
        if only:
            checks = {only: checks[only]}
        with LoopWatch() as watch:
            found = await findings_of(checks)
        if watch.held_up_s > HELD_UP_S:
            found.append(f"time: it held up the event loop for {watch.held_up_s:.1f} s")
        return found

    @asynccontextmanager
    async def _open(self) -> AsyncIterator[tuple[Bridge, RecordingDesk]]:
        desk = self._desk()
        bridge = self._make(desk)
        await bridge.open()
        try:
            yield bridge, desk
        finally:
            await bridge.close()

    async def _opened(self) -> None:
        desk = self._desk()
        bridge = self._make(desk)
        _check_status(bridge.status(), "before it is open")
        await bridge.open()
        try:
            _check_status(bridge.status(), "when it is open")
        finally:
            await bridge.close()

    async def _answer(self) -> None:
        async with self._open() as (bridge, _):
            await self._client.asked(bridge.status())

    async def _chunking(self) -> None:
        async with self._open() as (bridge, _):
            whole = await self._client.asked(bridge.status())
            pieces = await self._client.asked_byte_by_byte(bridge.status())
            if pieces != whole:
                raise Wrong(f"byte by byte the answer is {shown(pieces)} instead of {shown(whole)}")

    async def _silence(self) -> None:
        async with self._open() as (_, desk):
            await asyncio.sleep(STILL_S)
            if desk.done:
                raise Wrong(f"nobody asked, and it carried out {shown(desk.done)}")

    async def _garbage(self) -> None:
        random = Random(0)
        async with self._open() as (bridge, desk):
            for size in (1, 10, 1000, 100_000):
                await self._client.throw(bridge.status(), random.randbytes(size))
            if desk.done:
                raise Wrong(f"it carried out {shown(desk.done)}")
            await self._client.asked(bridge.status())

    async def _refusal(self) -> None:
        async with self._open() as (bridge, desk):
            desk.refusal = VerbRefused("not_now", "the check refuses everything now")
            with suppress(Wrong):  # an answer need not be one
                await self._client.asked(bridge.status())
            desk.refusal = None
            await self._client.asked(bridge.status())

    async def _devices(self) -> None:
        async with self._open() as (bridge, desk):
            gone = desk.devices.pop("m1")
            await bridge.devices_changed(["m1"])
            desk.devices |= {"m1": gone, "m3": replace(gone, name="m3")}
            await bridge.devices_changed(["m1", "m3"])
            await bridge.devices_changed(["m1"])
            await self._client.asked(bridge.status())

    async def _reset(self) -> None:
        answers = []
        for _ in range(2):
            async with self._open() as (bridge, _):
                answers.append(await self._client.asked(bridge.status()))
        if answers[0] != answers[1]:
            raise Wrong(f"made again it answers {shown(answers[1])} instead of {shown(answers[0])}")

    async def _replay(self) -> None:
        async with self._open() as (bridge, _):
            first, again = (
                await self._client.asked(bridge.status()),
                await self._client.asked(bridge.status()),
            )
        if first != again:
            raise Wrong(f"asked again it answers {shown(again)} instead of {shown(first)}")

    async def _limits(self) -> None:
        async with self._open() as (bridge, _):
            await self._many_come(bridge.status())
            await asyncio.sleep(STILL_S)
            if await self._client.is_heard_for_ever(bridge.status()):
                raise Wrong(f"it takes {ENDLESS_BYTES} bytes of a request that has no end")
            await self._client.asked(bridge.status())

    async def _many_come(self, status: Status) -> None:
        before, writers = descriptors(), []
        for _ in range(CLIENTS):
            with suppress(OSError):
                writers.append((await connected(status))[1])

        def kept() -> int:
            return descriptors() - before - len(writers)

        try:
            if not await until(lambda: kept() <= CLIENTS_KEPT, self._patience_s, STILL_S):
                raise Wrong(f"of {CLIENTS} silent clients at a time it keeps {kept()}")
        finally:
            for writer in writers:
                writer.transport.abort()

    async def _left(self) -> None:
        before = Before()
        async with self._open() as (bridge, desk):
            await self._client.asked(bridge.status())

        def left() -> str | None:
            return f"{len(desk.watches)} watches are left open" if desk.watches else before.left()

        await until_nothing_is(left, self._patience_s)


def _check_status(status: Status, when: str) -> None:
    if missing := [field for field in STATUS if field not in status]:
        raise Wrong(f"{when} its status has no {', '.join(missing)}")
    try:
        json.dumps(dict(status), allow_nan=False)
    except (TypeError, ValueError) as error:
        raise Wrong(f"{when} its status cannot be written: {raised(error)}") from None
