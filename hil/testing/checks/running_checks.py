"""Checks of what runs in an event loop: tried one after the other, and what they leave behind."""

import asyncio
import gc
import threading
import time
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from hil.testing.checks.findings import descriptors, raised, shown

BEAT_S = 0.01
STALLED_S = 0.25
"""A beat that took this long was held up by the computer: a busy one keeps a thread waiting some 0.1 s."""


class Wrong(Exception):
    """Finding of a check."""


async def findings_of(checks: Mapping[str, Callable[[], Awaitable[None]]]) -> list[str]:
    """Try checks, each under its word; answers a finding for each that is not passed. An error that a
    callback or a task raised meanwhile is one too."""
    errors: list[str] = []
    loop = asyncio.get_running_loop()
    loop.set_exception_handler(lambda _, about: errors.append(_error_of(about)))
    found = []
    for word, check in checks.items():
        errors.clear()
        try:
            await check()
            gc.collect()  # a task that failed unseen says so
        except Wrong as wrong:
            found.append(f"{word}: {wrong}")
        except Exception as error:  # theirs: it is what the check is for
            found.append(f"{word}: it raised {raised(error)}")
        else:
            found += [f"{word}: {error}" for error in errors[:1]]
    return found


def _error_of(about: dict[str, Any]) -> str:
    """Say what error a callback or a task of theirs raised."""
    error = about.get("exception")
    return f"it raised {raised(error)}" if error else str(about["message"])


async def until(condition: Callable[[], bool], patience_s: float, every_s: float = 0.001) -> bool:
    """Wait until a condition holds; answers False if it does not in this time."""
    end_s = time.monotonic() + patience_s
    while not condition():
        if time.monotonic() > end_s:
            return False
        await asyncio.sleep(every_s)
    return True


async def until_nothing_is(left: Callable[[], str | None], patience_s: float) -> None:
    """Wait until ``left`` says of nothing that it is left.

    Raises:
        Wrong: of something it still does.
    """
    await until(lambda: left() is None, patience_s, 0.01)
    if wrong := left():
        raise Wrong(wrong)


class Before:
    """File descriptors, tasks and threads that there were when this was made."""

    def __init__(self) -> None:
        self._descriptors = descriptors()
        self._tasks, self._threads = asyncio.all_tasks(), set(threading.enumerate())

    def left(self) -> str | None:
        """Say what has come since and has not gone; None: nothing."""
        if tasks := asyncio.all_tasks() - self._tasks:
            return f"tasks are left: {shown([task.get_name() for task in tasks])}"
        running = [thread.name for thread in set(threading.enumerate()) - self._threads]
        if threads := [name for name in running if not name.startswith("asyncio_")]:  # the loop's own
            return f"threads are left: {shown(threads)}"
        if (more := descriptors() - self._descriptors) > 0:
            return f"{more} file descriptors are left open"
        return None


class LoopWatch:
    """Watch of an event loop, while it is entered: ``held_up_s`` is the longest time for which something in
    the loop held it up."""

    def __init__(self) -> None:
        self.held_up_s = 0.0

    def __enter__(self) -> "LoopWatch":
        self._beside = _Beside()
        self._task = asyncio.create_task(self._beat())
        return self

    def __exit__(self, *_: object) -> None:
        self._task.cancel()
        self._beside.stop()

    async def _beat(self) -> None:
        while True:
            begin_s = self._beside.ran_s
            await asyncio.sleep(BEAT_S)
            self.held_up_s = max(self.held_up_s, self._beside.ran_s - begin_s - BEAT_S)


class _Beside:
    """Thread that does nothing either: what holds it up too is the computer. ``ran_s``: time for which it
    ran, without what it was held up for."""

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
