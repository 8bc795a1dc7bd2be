"""The client for asyncio: the same as the other, each exchange in a thread."""

import asyncio
from collections.abc import AsyncIterator, Coroutine, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

from hil.client.link import ENDPOINT, TIMEOUT_S, Link
from hil.client.messages import Ack, State, state_of
from hil.client.synchronous import Axis, Bench, connect_sync
from hil.client.verbs import MOTION_S, AxisVerbs

QUEUED = 10_000
"""States that wait; the oldest of more are dropped."""


class AsyncAxis(AxisVerbs[Coroutine[Any, Any, Ack]]):
    """As ``Axis``, to be awaited."""

    def __init__(self, link: Link, name: str) -> None:
        self.name = name
        self._link = link
        self._axis = Axis(link, name)

    async def do(self, verb: str, *, wait: bool = False, timeout_s: float = MOTION_S, **given: object) -> Ack:
        return await asyncio.to_thread(self._axis.do, verb, wait=wait, timeout_s=timeout_s, **given)

    def put(self, verb: str, **given: object) -> None:
        """Carry out a verb without an answer, at once: for set-points in a stream."""
        self._axis.put(verb, **given)

    async def state(self) -> State:
        """The present state, at most 20 ms old."""
        return await asyncio.to_thread(self._axis.state)

    async def states(self) -> AsyncIterator[State]:
        """States as they come."""
        loop = asyncio.get_running_loop()
        came: asyncio.Queue[bytes] = asyncio.Queue()

        def keep(text: bytes) -> None:
            if came.qsize() >= QUEUED:
                came.get_nowait()
            came.put_nowait(text)

        def take(text: bytes) -> None:
            loop.call_soon_threadsafe(keep, text)

        with self._link.subscribe(f"axis/{self.name}/state", take):
            while True:
                yield state_of(await came.get())

    async def parameter(self, name: str) -> float:
        """A settable field."""
        return await asyncio.to_thread(self._axis.parameter, name)

    async def set_parameter(self, name: str, value: float) -> Ack:
        """Set a settable field."""
        return await asyncio.to_thread(self._axis.set_parameter, name, value)

    async def fault(self, fault: str, **parameters: object) -> int:
        """Begin a fault; its number."""
        return await asyncio.to_thread(self._axis.fault, fault, **parameters)

    async def clear_fault(self, number: int | str = "all") -> None:
        """End a fault, or all."""
        await asyncio.to_thread(self._axis.clear_fault, number)


class AsyncBench:
    """A bench; ``async with connect(...)`` opens it."""

    def __init__(self, bench: str, arguments: dict[str, Any]) -> None:
        self.name = bench
        self._arguments = arguments
        self._bench: Bench | None = None

    async def __aenter__(self) -> "AsyncBench":
        self._bench = await asyncio.to_thread(connect_sync, self.name, **self._arguments)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await asyncio.to_thread(self._open.close)

    @property
    def _open(self) -> Bench:
        if self._bench is None:
            raise RuntimeError("open it first: async with connect(...) as bench")
        return self._bench

    def axis(self, name: str) -> AsyncAxis:
        """A device."""
        return AsyncAxis(self._open.link, name)

    async def submit(self, run: Mapping[str, object] | str) -> dict[str, Any]:
        """Submit a multi-axis run, as data or as YAML; its progress."""
        return await asyncio.to_thread(self._open.submit, run)

    async def run_state(self, name: str) -> dict[str, Any]:
        """The progress of a run."""
        return await asyncio.to_thread(self._open.run_state, name)

    async def cancel(self, name: str, how: Literal["grace", "prejudice"] = "grace") -> dict[str, Any]:
        """End a run."""
        return await asyncio.to_thread(self._open.cancel, name, how)

    async def perform(
        self, run: Mapping[str, object] | str, *, timeout_s: float = MOTION_S
    ) -> dict[str, Any]:
        """Submit a run and wait for its end; its last progress."""
        return await asyncio.to_thread(self._open.perform, run, timeout_s=timeout_s)

    async def alive(self) -> list[str]:
        """What is alive: ``daemon``, ``axis/m1``, ``segment/bus0``."""
        return await asyncio.to_thread(self._open.alive)

    async def clock(self) -> tuple[int, int]:
        """Simulated and wall time, ns."""
        return await asyncio.to_thread(self._open.clock)

    async def read(self, key: str) -> dict[str, Any]:
        """The document under a key of the bench, as in ``sim/health``."""
        return await asyncio.to_thread(self._open.read, key)


def connect(
    bench: str,
    endpoint: str = ENDPOINT,
    *,
    user: str | None = None,
    password: str = "",
    config: Path | str | None = None,
    timeout_s: float = TIMEOUT_S,
) -> AsyncBench:
    """A bench at a zenoh endpoint, opened by ``async with``; the rest as of ``connect_sync``.

    Raises:
        ClientError: nobody lets us in there.
    """
    arguments = {
        "endpoint": endpoint,
        "user": user,
        "password": password,
        "config": config,
        "timeout_s": timeout_s,
    }
    return AsyncBench(bench, arguments)
