"""Handling of signals in an event loop, whatever else rings."""

import asyncio
import signal
from collections.abc import Callable, Mapping
from contextlib import suppress
from types import FrameType


def answer(loop: asyncio.AbstractEventLoop, calls: Mapping[signal.Signals, Callable[[], None]]) -> None:
    """Let the loop make the call of each signal that comes.

    The loop's own way is a byte for each signal in a socket, in which the guard's bells are, too: 14 s in
    which the loop does not run fill it, and a SIGTERM that comes then was lost. So the byte only wakes the
    loop, which it does also where it finds no room, and Python's handler has the call made.
    """
    for number, call in calls.items():
        loop.add_signal_handler(number, lambda: None)
        signal.signal(number, _handler(loop, call))
    signal.set_wakeup_fd(signal.set_wakeup_fd(-1), warn_on_full_buffer=False)


def ignore(loop: asyncio.AbstractEventLoop, numbers: Mapping[signal.Signals, object]) -> None:
    """Handle these signals no more in the loop; Python's own handling is in force again."""
    for number in numbers:
        loop.remove_signal_handler(number)


def _handler(
    loop: asyncio.AbstractEventLoop, call: Callable[[], None]
) -> Callable[[int, FrameType | None], None]:
    def handle(number: int, frame: FrameType | None) -> None:
        with suppress(RuntimeError):  # the loop has ended
            loop.call_soon_threadsafe(call)

    return handle
