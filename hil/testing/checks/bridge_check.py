"""Check of a bridge: ``hil.vocab.bridge_protocol.Bridge``."""

import asyncio
import gc
import json
import threading
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager, suppress
from dataclasses import replace
from random import Random
from typing import Any

from hil.testing.checks.findings import CheckFailed, descriptors, raised, shown
from hil.testing.checks.recording_desk import RecordingDesk
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.desk_protocol import Desk
from hil.vocab.verbs import VerbRefused

PATIENCE_S = 5.0
STILL_S = 0.1
BEAT_S = 0.01
STALLED_S = 0.25
"""A beat that took this long was held up by the computer: a busy one keeps a thread waiting some 0.1 s."""
FIRST_S = 0.5
"""Silence after which the first answer is whole."""
HELD_UP_S = 1.0
"""Most time for which a bridge may hold up the event loop that serves the ports; its own limit is some ms."""
CLIENTS, CLIENTS_KEPT = 150, 100
ENDLESS_BYTES = 4 << 20
STATUS = ("root", "listen", "connect", "links", "insecure")

Ask = Callable[[Mapping[str, Any]], Awaitable[object]]
"""Asks a bridge for something as a client, by its ``status()``; answers what came."""


def check_bridge(
    make: Callable[[Desk], Bridge],
    *,
    request: bytes | None = None,
    ask: Ask | None = None,
    desk: Callable[[], RecordingDesk] = RecordingDesk,
    patience_s: float = PATIENCE_S,
) -> None:
    """Check a bridge. ``make``: makes one for a desk, not yet open. ``request``: bytes that are answered at
    the first address that it listens at, over TCP; or ``ask``, which asks in another way. ``desk``: makes the
    desk of a bench with a twin ``m1`` and a real board ``m2``. ``patience_s``: time in which what has to
    happen does.

    - opened: ``status()`` has its fields, before and after ``open``, and they can be written as JSON.
    - answer: the request is answered.
    - chunking: it is, alike, when its bytes come one by one.
    - silence: where nobody asks, nothing is carried out.
    - garbage: whatever comes, nothing is carried out, and the next request is answered.
    - refusal: what the bench refuses does not end it.
    - devices: boards that are added, removed and exchanged do not.
    - reset: closed and made anew, it answers as before.
    - replay: the same request has the same answer.
    - time: it never holds up the event loop.
    - limits: many clients at a time, and a request without an end, do not use up the computer.
    - left: ``close`` leaves no file descriptor, task, thread or watch.

    Raises:
        CheckFailed: with all that is wrong.
    """
    found = asyncio.run(_BridgeCheck(make, request, ask, desk, patience_s).all())
    if found:
        raise CheckFailed("the bridge", found)


class _Wrong(Exception):
    """What is wrong, if something is."""


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
        self._request, self._ask_it = request, ask or self._ask_by_tcp
        self._patience_s = patience_s
        self._held_up_s = 0.0
        self._answer_bytes = 0
        """Length of the first answer."""
        self._errors: list[str] = []

    async def all(self) -> list[str]:
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
        if self._request is None:
            del checks["chunking"], checks["limits"]
        asyncio.get_running_loop().set_exception_handler(self._note)
        beside = _Beside()
        beat = asyncio.create_task(self._beat(beside))
        found = [(word, await self._of(check)) for word, check in checks.items()]
        beat.cancel()
        beside.stop()
        if self._held_up_s > HELD_UP_S:
            found.append(("time", f"it held up the event loop for {self._held_up_s:.1f} s"))
        return [f"{word}: {wrong}" for word, wrong in found if wrong is not None]

    async def _of(self, check: Callable[[], Awaitable[None]]) -> str | None:
        self._errors.clear()
        try:
            await check()
        except _Wrong as wrong:
            return str(wrong)
        except Exception as error:  # theirs: it is what the check is for
            return f"it raised {raised(error)}"
        gc.collect()  # a task that failed unseen says so
        return self._errors[0] if self._errors else None

    def _note(self, _: object, about: dict[str, Any]) -> None:
        """Note an error that a callback or a task of theirs raised."""
        error = about.get("exception")
        self._errors.append(f"it raised {raised(error)}" if error else str(about["message"]))

    async def _beat(self, beside: "_Beside") -> None:
        while True:
            begin_s = beside.ran_s
            await asyncio.sleep(BEAT_S)
            self._held_up_s = max(self._held_up_s, beside.ran_s - begin_s - BEAT_S)

    # ---- what each check is made of ----

    @asynccontextmanager
    async def _open(self) -> AsyncIterator[tuple[Bridge, RecordingDesk]]:
        desk = self._desk()
        bridge = self._make(desk)
        await bridge.open()
        try:
            yield bridge, desk
        finally:
            await bridge.close()

    async def _asked(self, bridge: Bridge) -> object:
        try:
            async with asyncio.timeout(self._patience_s):
                answer = await self._ask_it(bridge.status())
        except (OSError, EOFError, TimeoutError) as error:
            raise _Wrong(f"a request was not answered: {raised(error)}") from None
        if not answer:
            raise _Wrong("a request was answered with nothing")
        return answer

    async def _ask_by_tcp(self, status: Mapping[str, Any], *, one_by_one: bool = False) -> bytes:
        assert self._request is not None, "give check_bridge a request, or ask"
        reader, writer = await asyncio.open_connection(*_address(status))
        try:
            for piece in [bytes([byte]) for byte in self._request] if one_by_one else [self._request]:
                writer.write(piece)
                await writer.drain()
                if one_by_one:
                    await asyncio.sleep(0.002)
            answer = await reader.read(1 << 16)
            while answer and len(answer) < self._answer_bytes and (more := await reader.read(1 << 16)):
                answer += more
            with suppress(TimeoutError):
                async with asyncio.timeout(STILL_S if self._answer_bytes else FIRST_S):
                    while more := await reader.read(1 << 16):
                        answer += more
            self._answer_bytes = self._answer_bytes or len(answer)
            return answer
        finally:
            writer.transport.abort()

    # ---- the checks ----

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
            await self._asked(bridge)

    async def _chunking(self) -> None:
        async with self._open() as (bridge, _):
            whole = await self._asked(bridge)
            try:
                async with asyncio.timeout(self._patience_s):
                    pieces = await self._ask_by_tcp(bridge.status(), one_by_one=True)
            except (OSError, TimeoutError) as error:
                raise _Wrong(f"a request that comes byte by byte is not answered: {raised(error)}") from None
            if pieces != whole:
                raise _Wrong(f"byte by byte the answer is {shown(pieces)} instead of {shown(whole)}")

    async def _silence(self) -> None:
        async with self._open() as (_, desk):
            await asyncio.sleep(STILL_S)
            if desk.done:
                raise _Wrong(f"nobody asked, and it carried out {shown(desk.done)}")

    async def _garbage(self) -> None:
        random = Random(0)
        async with self._open() as (bridge, desk):
            for size in (1, 10, 1000, 100_000):
                await self._thrown(bridge.status(), random.randbytes(size))
            if desk.done:
                raise _Wrong(f"it carried out {shown(desk.done)}")
            await self._asked(bridge)

    async def _thrown(self, status: Mapping[str, Any], data: bytes) -> None:
        """Throw bytes at an address, and leave."""
        if not status["listen"]:
            return
        loop, address = asyncio.get_running_loop(), _address(status)
        with suppress(OSError, TimeoutError):
            transport, _ = await loop.create_datagram_endpoint(asyncio.DatagramProtocol, remote_addr=address)
            transport.sendto(data[:1000])
            await asyncio.sleep(0)
            transport.close()
        with suppress(OSError, TimeoutError):
            _, writer = await asyncio.open_connection(*address)
            writer.write(data)
            with suppress(OSError, TimeoutError):
                async with asyncio.timeout(STILL_S):
                    await writer.drain()
            writer.transport.abort()
        await asyncio.sleep(STILL_S)

    async def _refusal(self) -> None:
        async with self._open() as (bridge, desk):
            desk.refusal = VerbRefused("not_now", "the check refuses everything now")
            with suppress(_Wrong):  # an answer need not be one
                await self._asked(bridge)
            desk.refusal = None
            await self._asked(bridge)

    async def _devices(self) -> None:
        async with self._open() as (bridge, desk):
            gone = desk.devices.pop("m1")
            await bridge.devices_changed(["m1"])
            desk.devices |= {"m1": gone, "m3": replace(gone, name="m3")}
            await bridge.devices_changed(["m1", "m3"])
            await bridge.devices_changed(["m1"])
            await self._asked(bridge)

    async def _reset(self) -> None:
        answers = []
        for _ in range(2):
            async with self._open() as (bridge, _):
                answers.append(await self._asked(bridge))
        if answers[0] != answers[1]:
            raise _Wrong(f"made anew it answers {shown(answers[1])} instead of {shown(answers[0])}")

    async def _replay(self) -> None:
        async with self._open() as (bridge, _):
            first, again = await self._asked(bridge), await self._asked(bridge)
        if first != again:
            raise _Wrong(f"asked again it answers {shown(again)} instead of {shown(first)}")

    async def _limits(self) -> None:
        async with self._open() as (bridge, _):
            before, writers = descriptors(), []
            for _ in range(CLIENTS):
                with suppress(OSError):
                    writers.append((await asyncio.open_connection(*_address(bridge.status())))[1])
            end_s = time.monotonic() + self._patience_s
            while (kept := descriptors() - before - len(writers)) > CLIENTS_KEPT and time.monotonic() < end_s:
                await asyncio.sleep(STILL_S)
            for writer in writers:
                writer.transport.abort()
            if kept > CLIENTS_KEPT:
                raise _Wrong(f"of {CLIENTS} silent clients at a time it keeps {kept}")
            await asyncio.sleep(STILL_S)
            if await self._takes_all(bridge.status()):
                raise _Wrong(f"it takes {ENDLESS_BYTES} bytes of a request that has no end")
            await self._asked(bridge)

    async def _takes_all(self, status: Mapping[str, Any]) -> bool:
        """Whether a client is read, and kept, that sends one letter for ever."""
        reader, writer = await asyncio.open_connection(*_address(status))
        is_taken = False
        try:
            async with asyncio.timeout(self._patience_s):
                for _ in range(ENDLESS_BYTES // 65536):
                    writer.write(b"a" * 65536)
                    await writer.drain()
                is_taken = True
                await reader.read(1)
                return False  # it says why not, or leaves
        except ConnectionError:
            return False
        except TimeoutError:
            return is_taken
        finally:
            writer.transport.abort()

    async def _left(self) -> None:
        before, tasks, threads = descriptors(), asyncio.all_tasks(), set(threading.enumerate())
        async with self._open() as (bridge, desk):
            await self._asked(bridge)
        end_s = time.monotonic() + self._patience_s
        while (wrong := self._rest(desk, before, tasks, threads)) and time.monotonic() < end_s:
            await asyncio.sleep(0.01)
        if wrong:
            raise _Wrong(wrong)

    @staticmethod
    def _rest(
        desk: RecordingDesk, before: int, tasks: set[asyncio.Task[Any]], threads: set[threading.Thread]
    ) -> str | None:
        """What a closed bridge has left."""
        if desk.watches:
            return f"{len(desk.watches)} watches are left open"
        if left := asyncio.all_tasks() - tasks:
            return f"tasks are left: {shown([task.get_name() for task in left])}"
        running = [thread.name for thread in set(threading.enumerate()) - threads]
        if left_running := [name for name in running if not name.startswith("asyncio_")]:  # the loop's own
            return f"threads are left: {shown(left_running)}"
        if (more := descriptors() - before) > 0:
            return f"{more} file descriptors are left open"
        return None


class _Beside:
    """Thread that does nothing either: what holds it up too is the computer, and no bridge. ``ran_s``: time
    for which it ran, without what it was held up for."""

    def __init__(self) -> None:
        self._is_over = threading.Event()
        self.ran_s = 0.0
        self._thread = threading.Thread(target=self._beat, name="beside")
        self._thread.start()

    def _beat(self) -> None:
        begin_s = time.monotonic()
        while not self._is_over.wait(BEAT_S):
            now_s = time.monotonic()
            if now_s - begin_s < STALLED_S:
                self.ran_s += now_s - begin_s
            begin_s = now_s

    def stop(self) -> None:
        self._is_over.set()
        self._thread.join()


def _check_status(status: Mapping[str, Any], when: str) -> None:
    if missing := [field for field in STATUS if field not in status]:
        raise _Wrong(f"{when} its status has no {', '.join(missing)}")
    try:
        json.dumps(dict(status), allow_nan=False)
    except (TypeError, ValueError) as error:
        raise _Wrong(f"{when} its status cannot be written: {raised(error)}") from None


def _address(status: Mapping[str, Any]) -> tuple[str, int]:
    """Host and port of the first address, as in ``127.0.0.1:80`` or ``tcp/[::1]:7447``."""
    host, _, number = str(status["listen"][0]).rpartition("/")[2].rpartition(":")
    return host.strip("[]"), int(number)
