"""Threads of a program on simulated time."""

import threading
from collections.abc import Callable
from typing import Any

from hil.testing.owned_time.owned_locks import until_ns
from hil.testing.owned_time.thread_turn import Turn
from hil.testing.owned_time.turns import Turns

_TURN = "_hil_turn"


class Threads:
    """Start, join and end of a program's threads. ``start_real``: Python's own way to start one."""

    def __init__(self, turns: Turns, start_real: Callable[..., Any]) -> None:
        self._turns, self._start_real = turns, start_real
        setattr(threading.main_thread(), _TURN, turns.main)

    def start_new_thread(
        self, function: Callable[..., object], args: tuple[Any, ...] = (), kwargs: Any = None, **real: Any
    ) -> Any:
        """Start a thread, as ``_thread.start_new_thread`` and ``start_joinable_thread`` do."""
        thread = getattr(function, "__self__", None)
        turn = self._turns.enlist(getattr(thread, "name", "a thread"))
        if isinstance(thread, threading.Thread):
            setattr(thread, _TURN, turn)

        def run() -> None:
            self._turns.begin(turn)
            try:
                function(*args, **(kwargs or {}))
            finally:
                self._turns.retire(turn)

        return self._start_real(run, **real) if real else self._start_real(run, ())

    def join(self, thread: threading.Thread, timeout: float | None = None) -> None:
        """Wait for a thread's end, as ``Thread.join``."""
        turn = getattr(thread, _TURN, None)
        if turn is None:
            raise RuntimeError("cannot join thread before it is started")
        if turn is self._turns.mine:
            raise RuntimeError("cannot join current thread")
        limit_ns = until_ns(self._turns, None if timeout is None else max(timeout, 0))
        self._turns.wait(lambda: turn.is_over, limit_ns, f"the end of {thread.name}")

    def is_alive(self, thread: threading.Thread) -> bool:
        """True from a thread's start to its end, as ``Thread.is_alive``."""
        turn: Turn | None = getattr(thread, _TURN, None)
        return turn is not None and not turn.is_over

    def shut_down(self) -> None:
        """Wait for all threads but daemons, as ``threading._shutdown`` at the end of the program."""
        for call in reversed(getattr(threading, "_threading_atexits", [])):
            call()
        while not self._turns.is_given_up:
            left = [t for t in threading.enumerate() if not t.daemon and t is not threading.main_thread()]
            if not left:
                return
            for each in left:
                self.join(each)
