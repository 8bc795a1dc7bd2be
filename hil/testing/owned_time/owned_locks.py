"""Locks of a program on simulated time. All else of ``threading`` and ``queue`` is made of these."""

import math
from typing import Any

from hil.testing.owned_time.thread_turn import Turn
from hil.testing.owned_time.turns import Turns
from hil.vocab.time import FOREVER, NS_PER_S


def until_ns(turns: Turns, timeout_s: float | None) -> int:
    """Simulated time at which a time-out is over; None and -1: never."""
    if timeout_s is None or timeout_s < 0:
        return FOREVER
    return min(turns.now_ns + math.ceil(timeout_s * NS_PER_S), FOREVER)


def lock_classes(turns: Turns) -> tuple[type[Any], type[Any]]:
    """Make ``Lock`` and ``RLock`` for a program."""

    class Lock:
        """``threading.Lock`` on simulated time."""

        def __init__(self) -> None:
            self._owner: Turn | None = None
            self._count = 0

        def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
            if not blocking and timeout != -1:
                raise ValueError("can't specify a timeout for a non-blocking call")
            if timeout < 0 and timeout != -1:
                raise ValueError("timeout value must be a non-negative number")
            if self._count == 0:
                turns.free_lock()  # before it is taken: others may want it
            if self._count == 0:
                self._take()
                return True
            if not blocking or timeout == 0:
                turns.look()
            else:
                turns.wait(self._is_free, until_ns(turns, timeout), self._what(timeout))
            if self._count:
                return False
            self._take()
            return True

        def _take(self) -> None:
            self._owner, self._count = turns.mine, 1

        def _is_free(self) -> bool:
            return self._count == 0

        def _what(self, timeout_s: float) -> str:
            at_most = "" if timeout_s < 0 else f", for at most {timeout_s:g} s"
            if self._owner is turns.mine:  # so threading waits
                return f"an event, a condition, a queue or a lock of its own{at_most}"
            return f"a lock that {self._owner.name} has{at_most}" if self._owner else f"a lock{at_most}"

        def release(self) -> None:
            if self._count == 0:
                raise RuntimeError("release unlocked lock")
            self._owner, self._count = None, 0

        def locked(self) -> bool:
            return self._count > 0

        def _at_fork_reinit(self) -> None:
            self._owner, self._count = None, 0

        acquire_lock, release_lock, locked_lock = acquire, release, locked

        def __enter__(self) -> bool:
            return self.acquire()

        def __exit__(self, *_: object) -> None:
            self.release()

    class RLock(Lock):
        """``threading.RLock`` on simulated time."""

        def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
            if self._count and self._owner is turns.mine:
                self._count += 1
                return True
            return super().acquire(blocking, timeout)

        __enter__ = acquire

        def release(self) -> None:
            if self._owner is not turns.mine:
                raise RuntimeError("cannot release un-acquired lock")
            self._count -= 1
            if not self._count:
                self._owner = None

        def _is_owned(self) -> bool:
            return self._owner is turns.mine

        def _recursion_count(self) -> int:
            return self._count if self._is_owned() else 0

        def _release_save(self) -> tuple[int, Turn | None]:
            if not self._count:
                raise RuntimeError("cannot release un-acquired lock")
            saved = self._count, self._owner
            self._owner, self._count = None, 0
            return saved

        def _acquire_restore(self, saved: tuple[int, Turn | None]) -> None:
            super().acquire()
            self._count, self._owner = saved

    return Lock, RLock
