"""Timer for silences on a line, finer than those of the event loop.

The loop waits in epoll, for whole milliseconds, rounded up: a silence of 1.75 ms is told 0.25 ms late at
best, one of 2.01 ms 0.99 ms. A timerfd of Linux counts nanoseconds, and the loop wakes for it as for any
file. Python has it from 3.13 on; until then ``ctypes`` calls it.
"""

import asyncio
import ctypes
import os
from collections.abc import Callable

_CLOCK_MONOTONIC = 1  # linux/time.h
_TFD_FLAGS = os.O_NONBLOCK | os.O_CLOEXEC  # TFD_NONBLOCK | TFD_CLOEXEC, linux/timerfd.h
_COUNT_BYTES = 8
_S_TO_NS = 1_000_000_000

_libc = ctypes.CDLL(None, use_errno=True)
_Times = ctypes.c_long * 4  # struct itimerspec: interval and time until the first, each in s and ns


class SilenceTimer:
    """Timer that calls ``told`` once, on the running loop, when nothing has started it again for so long.

    What the loop reads in the same pass goes first and may start it again: after a stall of the loop, bytes
    that came in time still belong to their frame. On a loop with a clock of its own (simulated time), and
    where no file is left, it is the loop's timer.
    """

    def __init__(self, told: Callable[[], None]) -> None:
        self._told = told
        self._loop = asyncio.get_running_loop()
        self._due: asyncio.Handle | None = None
        self._fd = _libc.timerfd_create(_CLOCK_MONOTONIC, _TFD_FLAGS) if _is_real(self._loop) else -1
        if self._fd >= 0:
            self._loop.add_reader(self._fd, self._is_over)

    def start(self, silence_ns: int) -> None:
        """Start it, or start it again."""
        self._forget()
        if self._fd >= 0:
            self._set(max(1, silence_ns))  # 0 would switch it off
        else:
            self._due = self._loop.call_later(silence_ns / _S_TO_NS, self._told)

    def close(self) -> None:
        """Stop it, and give its file back. It cannot be started any more."""
        self._forget()
        if self._fd >= 0:
            self._loop.remove_reader(self._fd)
            os.close(self._fd)
            self._fd = -1

    def _set(self, from_now_ns: int) -> None:
        times = _Times(0, 0, *divmod(from_now_ns, _S_TO_NS))
        if _libc.timerfd_settime(self._fd, 0, times, None) < 0:
            number = ctypes.get_errno()
            raise OSError(number, f"timerfd_settime: {os.strerror(number)}")

    def _is_over(self) -> None:
        try:
            os.read(self._fd, _COUNT_BYTES)
        except BlockingIOError:
            return  # started again in this pass
        self._due = self._loop.call_soon(self._told)

    def _forget(self) -> None:
        if self._due:
            self._due.cancel()
            self._due = None


def _is_real(loop: asyncio.AbstractEventLoop) -> bool:
    """True if the loop's time is that of the computer's clock."""
    return type(loop).time is asyncio.SelectorEventLoop.time
