"""Client for asyncio: the same as the synchronous one, each exchange in a thread."""

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, TypeVar

from hil.client.link import ENDPOINT, TIMEOUT_S
from hil.client.messages import Ack, State, state_of
from hil.client.synchronous import Axis, Bench, connect_sync
from hil.client.verbs import AxisVerbs

QUEUED = 10_000
"""Maximum number of states that wait; the oldest of more are dropped."""
Given = ParamSpec("Given")
Result = TypeVar("Result")


def _awaited(
    method: Callable[Concatenate[Any, Given], Result],
) -> Callable[Concatenate[Any, Given], Coroutine[Any, Any, Result]]:
    """Wrap a method of the client that blocks, to run in a thread."""

    @wraps(method)
    async def ask(self: Any, /, *given: Given.args, **named: Given.kwargs) -> Result:
        return await asyncio.to_thread(method, self._blocking, *given, **named)

    return ask


class AsyncAxis(AxisVerbs[Coroutine[Any, Any, Ack]]):
    """``Axis`` whose methods are awaited; ``put`` is at once."""

    def __init__(self, blocking: Axis) -> None:
        self.name = blocking.name
        self.put = blocking.put
        self._blocking = blocking

    do = _awaited(Axis.do)
    state = _awaited(Axis.state)
    parameter = _awaited(Axis.parameter)
    set_parameter = _awaited(Axis.set_parameter)
    fault = _awaited(Axis.fault)
    clear_fault = _awaited(Axis.clear_fault)

    async def states(self) -> AsyncIterator[State]:
        """Iterate over states as they come."""
        loop = asyncio.get_running_loop()
        came: asyncio.Queue[bytes] = asyncio.Queue()

        def keep(text: bytes) -> None:
            if came.qsize() >= QUEUED:
                came.get_nowait()
            came.put_nowait(text)

        with self._blocking.subscribe(lambda text: loop.call_soon_threadsafe(keep, text)):
            while True:
                yield state_of(await came.get())


class AsyncBench:
    """``Bench`` whose methods are awaited; ``async with connect(...)`` opens it."""

    def __init__(self, bench: str, connect: Callable[[], Bench]) -> None:
        self.name = bench
        self._connect = connect
        self._bench: Bench | None = None

    async def __aenter__(self) -> "AsyncBench":
        self._bench = await asyncio.to_thread(self._connect)
        return self

    async def __aexit__(self, *_: object) -> None:
        await asyncio.to_thread(self._blocking.close)

    @property
    def _blocking(self) -> Bench:
        if self._bench is None:
            raise RuntimeError("open it first: async with connect(...) as bench")
        return self._bench

    def axis(self, name: str) -> AsyncAxis:
        """Axis of a device."""
        return AsyncAxis(self._blocking.axis(name))

    submit = _awaited(Bench.submit)
    run_state = _awaited(Bench.run_state)
    cancel = _awaited(Bench.cancel)
    perform = _awaited(Bench.perform)
    leased = _awaited(Bench.leased)
    lease = _awaited(Bench.lease)
    renew_lease = _awaited(Bench.renew_lease)
    give_lease = _awaited(Bench.give_lease)
    break_lease = _awaited(Bench.break_lease)
    alive = _awaited(Bench.alive)
    clock = _awaited(Bench.clock)
    read = _awaited(Bench.read)


def connect(
    bench: str,
    endpoint: str = ENDPOINT,
    *,
    user: str | None = None,
    password: str = "",
    config: Path | str | None = None,
    timeout_s: float = TIMEOUT_S,
) -> AsyncBench:
    """Connect to a bench at a zenoh endpoint, opened by ``async with``; the rest as of ``connect_sync``.

    Raises:
        ClientError: nobody lets us in there.
    """

    def connected() -> Bench:
        return connect_sync(bench, endpoint, user=user, password=password, config=config, timeout_s=timeout_s)

    return AsyncBench(bench, connected)
