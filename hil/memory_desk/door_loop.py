"""Event loop on simulated time: it never waits."""

import asyncio
import selectors
from collections.abc import Callable, Coroutine, Iterator, Mapping
from contextlib import contextmanager
from contextvars import Context
from typing import Any, TypeVar, TypeVarTuple

from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs

Result = TypeVar("Result")
Given = TypeVarTuple("Given")


class _NoWait(selectors.BaseSelector):
    """Selector of a loop that goes on until nothing is ready, and then stops. ``idle``: called with the time
    to its next timer in seconds; None: it has none."""

    def __init__(self, idle: Callable[[float | None], None]) -> None:
        self._idle = idle
        self._keys: dict[Any, selectors.SelectorKey] = {}

    def register(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        """Note a file, which is never looked at: the loop's own, with which threads wake it."""
        number = fileobj if isinstance(fileobj, int) else fileobj.fileno()
        key = self._keys[fileobj] = selectors.SelectorKey(fileobj, number, events, data)
        return key

    def unregister(self, fileobj: Any) -> selectors.SelectorKey:
        return self._keys.pop(fileobj)

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if timeout != 0:
            self._idle(timeout)
        return []

    def get_map(self) -> Mapping[Any, selectors.SelectorKey]:
        return self._keys


class DoorLoop(asyncio.SelectorEventLoop):
    """Loop whose clock is ``now_ns``. It runs in ``turn``, and there alone; what is due later waits for the
    turn at ``due_ns``."""

    def __init__(self, now_ns: Callable[[], SimTimeNs]) -> None:
        self._now_ns = now_ns
        self._due_ns = FOREVER
        self._has_more = False
        super().__init__(_NoWait(self._is_idle))

    def _make_self_pipe(self) -> None:
        """Leave out the sockets by which other threads wake a loop: doors in memory have no threads. Of a
        bench that nobody closes, the collector would find them before the loop that closes them."""

    def _close_self_pipe(self) -> None:
        """Close nothing: there are no such sockets."""

    def _write_to_self(self) -> None:
        """Wake nothing: the loop never waits."""

    def call_exception_handler(self, context: dict[str, Any]) -> None:
        """Say what went wrong in a task or a callback. A task that ends with its bench is none of that."""
        if not context["message"].startswith("Task was destroyed"):
            super().call_exception_handler(context)

    def time(self) -> float:
        return self._now_ns() / NS_PER_S

    @property
    def due_ns(self) -> SimTimeNs:
        """Time of the next turn; ``FOREVER``: nothing is due."""
        return self._now_ns() if self._has_more else self._due_ns

    def turn(self) -> None:
        """Run all that is due now."""
        if self.is_running() or self.is_closed():
            return
        with _outside_of_loops():
            self.run_forever()

    def call_soon(
        self, callback: Callable[[*Given], object], *args: *Given, context: Context | None = None
    ) -> asyncio.Handle:
        self._has_more = True
        return super().call_soon(callback, *args, context=context)

    call_soon_threadsafe = call_soon
    """The same: doors in memory have no threads."""

    def call_at(
        self,
        when: float,
        callback: Callable[[*Given], object],
        *args: *Given,
        context: Context | None = None,
    ) -> asyncio.TimerHandle:
        self._due_ns = min(self._due_ns, SimTimeNs(round(when * NS_PER_S)))
        return super().call_at(when, callback, *args, context=context)

    def complete(self, work: Coroutine[Any, Any, Result]) -> Result:
        """Carry out a coroutine that takes no time."""
        task = self.create_task(work)
        self.turn()
        return task.result()

    def end(self) -> None:
        """Cancel all tasks, and close the loop."""
        if self.is_closed():
            return
        for task in asyncio.all_tasks(self):
            task.cancel()
        self.turn()
        self.close()

    def __del__(self, _warn: object = None) -> None:
        """Close it with the bench that it is of, which nobody has to close."""
        if not self.is_closed():
            self.close()

    def run_in_executor(
        self, executor: Any, func: Callable[[*Given], Result], *args: *Given
    ) -> asyncio.Future[Result]:
        """Call the function at once: a thread would answer at another time each time."""
        done: asyncio.Future[Result] = self.create_future()
        try:
            done.set_result(func(*args))
        except Exception as error:
            done.set_exception(error)
        return done

    def _is_idle(self, timeout_s: float | None) -> None:
        self._due_ns = (
            FOREVER if timeout_s is None else SimTimeNs(self._now_ns() + max(1, round(timeout_s * NS_PER_S)))
        )
        self._has_more = False
        self.stop()


@contextmanager
def _outside_of_loops() -> Iterator[None]:
    """Context in which a loop can run beside the one that runs already, in the middle of a task of which."""
    loop = asyncio._get_running_loop()
    task = asyncio.current_task(loop) if loop else None
    if loop and task:
        asyncio.tasks._leave_task(loop, task)
    asyncio._set_running_loop(None)
    try:
        yield
    finally:
        asyncio._set_running_loop(loop)
        if loop and task:
            asyncio.tasks._enter_task(loop, task)
