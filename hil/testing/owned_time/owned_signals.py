"""Signals of a program on simulated time: its timers, its handlers, and waits for a signal.

Linux delivers every signal, so masks, ``sigpending`` and ``set_wakeup_fd`` are its own. A handler runs while
the main thread has its turn: one for which a signal comes in the midst of a wait runs at the next turn.
"""

import _thread
import math
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from types import FrameType
from typing import Any

from hil.testing.owned_time.owned_locks import until_ns
from hil.testing.owned_time.thread_turn import Interrupts, is_hils, is_pythons
from hil.testing.owned_time.turns import Turns
from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs

_signal, _getsignal = signal.signal, signal.getsignal
_setitimer, _getitimer = signal.setitimer, signal.getitimer
_sigtimedwait, _sigpending = signal.sigtimedwait, signal.sigpending
_kill, _raise_signal, _pthread_kill = os.kill, signal.raise_signal, signal.pthread_kill
_interrupt_main = _thread.interrupt_main
_sleep, _clock = time.sleep, time.monotonic
_LOOK_S = 0.0001
_NOTICE_S = 1.0
"""Maximum wall time in which the main thread notices a signal, unless it is in C code."""


class Handler:
    """Handler of the program, as Python has it. ``run``: calls it, now or at the main thread's next turn."""

    def __init__(self, given: Callable[..., object], run: Callable[[int, FrameType | None], None]) -> None:
        self.given, self._run = given, run

    def __call__(self, number: int, frame: FrameType | None) -> None:
        self._run(number, frame)


def _given(handler: Any) -> Any:
    return handler.given if isinstance(handler, Handler) else handler


def _of_others(frame: FrameType | None) -> FrameType | None:
    """First frame from here up that is not hil's."""
    while frame and is_hils(frame.f_code.co_filename):
        frame = frame.f_back
    return frame


def _is_in_hil(frame: FrameType | None) -> bool:
    """True if a call of hil's was interrupted, or one of Python's library for it."""
    while frame and is_pythons(frame.f_code.co_filename):
        frame = frame.f_back
    return bool(frame and is_hils(frame.f_code.co_filename))


class OwnedSignals(Interrupts):
    """Signals of a program, and the one timer that Linux has for a process in real time (ITIMER_REAL); others
    stay Python's."""

    def __init__(self, turns: Turns) -> None:
        self._turns = turns
        self._timer_ns: SimTimeNs = FOREVER
        self._interval_ns = 0
        self._handled = 0
        self._noticed = 0
        self._held = deque[int]()
        """Signals that came while the main thread could not run a handler."""
        self._delivers = False
        for number in signal.valid_signals():
            if callable(handler := _getsignal(number)):
                _signal(number, Handler(handler, self._notice))

    # ---- timers ----

    @property
    def due_ns(self) -> SimTimeNs:
        """Time at which the main thread is interrupted next."""
        return SimTimeNs(0) if self._held else self._timer_ns

    def setitimer(self, which: int, seconds: float, interval: float = 0.0) -> tuple[float, float]:
        """Set a timer; answers what was left of the one before, as ``signal.setitimer``."""
        if which != signal.ITIMER_REAL:
            return _setitimer(which, seconds, interval)
        if seconds < 0 or interval < 0:
            raise signal.ItimerError(22, "Invalid argument")
        left = self.getitimer(which)
        self._interval_ns = math.ceil(interval * NS_PER_S)
        now_ns = self._turns.now_ns
        self._timer_ns = SimTimeNs(now_ns + math.ceil(seconds * NS_PER_S)) if seconds else FOREVER
        return left

    def getitimer(self, which: int) -> tuple[float, float]:
        """Time left and interval of a timer, in seconds."""
        if which != signal.ITIMER_REAL:
            return _getitimer(which)
        left_ns = 0 if self._timer_ns == FOREVER else max(self._timer_ns - self._turns.now_ns, 1)
        return left_ns / NS_PER_S, self._interval_ns / NS_PER_S

    def alarm(self, seconds: int) -> int:
        """Set the timer in whole seconds; answers what was left."""
        left_s, _ = self.setitimer(signal.ITIMER_REAL, int(seconds))
        return math.ceil(left_s)

    def _ring(self, now_ns: SimTimeNs) -> None:
        """Let the timer send its signal, if it is due."""
        if self._timer_ns > now_ns:
            return
        next_ns = max(self._timer_ns + self._interval_ns, now_ns + 1) if self._interval_ns else FOREVER
        self._timer_ns = SimTimeNs(next_ns)
        _kill(os.getpid(), signal.SIGALRM)

    # ---- handlers ----

    def ring_beside(self, now_ns: SimTimeNs) -> None:
        """Send what is due to a main thread that does not wait."""
        while self._held:
            _kill(os.getpid(), self._held.popleft())
        self._ring(now_ns)

    def run(self, now_ns: SimTimeNs) -> None:
        """Call the handlers that are due, on the main thread at its turn."""
        self._at_once(self._ring, now_ns)
        while self._held:
            number = self._held.popleft()
            if callable(handler := _given(_getsignal(number))):
                self._handle(handler, number, None)

    def _at_once(self, send: Callable[..., Any], *options: Any) -> Any:
        """Send a signal on the main thread, which handles it before this returns."""
        self._delivers = True
        try:
            return send(*options)
        finally:
            self._delivers = False

    def _notice(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal that has come: at once, or at the next turn where a wait was interrupted."""
        is_busy = self._turns.works_here or _is_in_hil(frame)
        if is_busy and not self._delivers:
            self._held.append(number)
            self._noticed += 1  # at last: the sender goes on then
        else:
            self._noticed += 1
            self._handle(_given(_getsignal(number)), number, frame)

    def _handle(self, handler: Callable[..., object], number: int, frame: FrameType | None) -> None:
        self._handled += 1
        self._delivers = False  # what the handler calls may be interrupted as all else
        handler(number, _of_others(frame or sys._getframe()))

    def set_handler(self, number: int, handler: Any) -> Any:
        """Set a handler; answers the one before, as ``signal.signal``."""
        return _given(_signal(number, Handler(handler, self._notice) if callable(handler) else handler))

    def handler(self, number: int) -> Any:
        """Handler of a signal."""
        return _given(_getsignal(number))

    # ---- sending ----

    def kill(self, pid: int, number: int) -> None:
        """Send a signal, as ``os.kill``."""
        if pid == os.getpid():
            self._send(number, _kill, pid, number)
        else:
            _kill(pid, number)

    def raise_signal(self, number: int) -> None:
        """Send this process a signal, as ``signal.raise_signal``."""
        self._send(number, _raise_signal, number)

    def pthread_kill(self, thread: int, number: int) -> None:
        """Send a thread a signal, as ``signal.pthread_kill``."""
        self._send(number, _pthread_kill, thread, number)

    def interrupt_main(self, number: int = signal.SIGINT) -> None:
        """Interrupt the main thread, as ``_thread.interrupt_main``."""
        self._send(number, _interrupt_main, number)

    def _send(self, number: int, send: Callable[..., None], *options: int) -> None:
        """Send this process a signal, which the main thread has noticed when this returns, so that it is
        handled at the same time in each run."""
        if threading.current_thread() is threading.main_thread():
            self._at_once(send, *options)
            return
        noticed, end_s = self._noticed, _clock() + _NOTICE_S
        send(*options)
        while self._noticed == noticed and isinstance(_getsignal(number), Handler) and _clock() < end_s:
            if number in _sigpending():
                return
            self._turns.wake_main()
            _sleep(_LOOK_S)

    # ---- waiting ----

    def pause(self) -> None:
        """Wait for a signal that has a handler."""
        seen = self._handled
        self._turns.wait(lambda: self._handled != seen, FOREVER, "a signal")

    def sigtimedwait(self, sigset: Iterable[int], timeout: float | None) -> Any:
        """Wait for a blocked signal; None: the time-out is over."""
        wanted = [*sigset]
        if (found := _sigtimedwait(wanted, 0)) or timeout == 0:
            return found

        def ready() -> bool:
            nonlocal found
            found = _sigtimedwait(wanted, 0)
            return found is not None

        self._turns.wait(ready, until_ns(self._turns, timeout), "a signal")
        return found

    def sigwaitinfo(self, sigset: Iterable[int]) -> Any:
        """Wait for a blocked signal."""
        return self.sigtimedwait(sigset, None)

    def sigwait(self, sigset: Iterable[int]) -> signal.Signals:
        """Wait for a blocked signal; answers its number."""
        return signal.Signals(self.sigtimedwait(sigset, None).si_signo)
