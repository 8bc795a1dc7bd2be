"""Long work in a thread: ports, runs and clients do not wait for it. It ends with its caller."""

import asyncio
import ctypes
import threading
from collections.abc import Callable, Sized
from contextlib import suppress
from functools import partial
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

SHORT = 8192
"""Maximum characters of a run, or rows, that are worked on at once: some 50 ms."""
AT_ONCE = 2
"""Maximum number of such threads of a loop: each takes the interpreter from it for up to 5 ms."""
AGAIN_S = 0.05
"""Time until a thread that has not ended is told to again: what runs when an object goes cannot raise."""
T = TypeVar("T")

_turns: "WeakKeyDictionary[asyncio.AbstractEventLoop, asyncio.Semaphore]" = WeakKeyDictionary()


_Stopped = SystemExit
"""Raised in a thread whose work nobody waits for: wherever it strikes, a thread ends by it silently."""


async def off_loop(source: Sized, call: Callable[..., T], *arguments: Any) -> T:
    """Call with the arguments, in a thread if their source is long: a text, rows. The work is pure: if this
    is cancelled, it ends wherever it is."""
    if len(source) <= SHORT:
        return call(*arguments)
    return await stoppable(partial(call, *arguments))


async def stoppable(work: Callable[[], T]) -> T:
    """Do pure work in a thread, which is stopped if this is cancelled and keeps no process from ending."""
    loop = asyncio.get_running_loop()
    async with _turns.setdefault(loop, asyncio.Semaphore(AT_ONCE)):
        return await _in_thread(loop, work)


async def _in_thread(loop: asyncio.AbstractEventLoop, work: Callable[[], T]) -> T:
    outcome: asyncio.Future[T] = loop.create_future()

    def tell(call: Callable[[Any], None], what: Any) -> None:
        if not outcome.done():
            call(what)

    def go_on() -> None:
        with suppress(_Stopped, RuntimeError):  # RuntimeError: the loop has ended
            try:
                done = partial(tell, outcome.set_result, work())
            except Exception as error:  # the waiter gets it
                done = partial(tell, outcome.set_exception, error)
            loop.call_soon_threadsafe(done)

    thread = threading.Thread(target=go_on, name="off-loop", daemon=True)
    thread.start()
    try:
        return await outcome
    except asyncio.CancelledError:
        _stop(loop, thread)
        raise


def _stop(loop: asyncio.AbstractEventLoop, thread: threading.Thread) -> None:
    """Raise ``_Stopped`` in a thread, as soon as it carries out Python again, until it has ended."""
    if thread.is_alive():
        ident, error = ctypes.c_ulong(thread.ident or 0), ctypes.py_object(_Stopped)
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ident, error)
        loop.call_later(AGAIN_S, _stop, loop, thread)
