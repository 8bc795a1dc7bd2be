"""Timers by signal of a program on simulated time: ``alarm``, ``setitimer``, ``pause``."""

import math
import os
import signal
from types import FrameType

from hil.testing.owned_time.turns import Interrupts, Turns
from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs

_setitimer, _getitimer = signal.setitimer, signal.getitimer


class SignalTimers(Interrupts):
    """The one timer that Linux has for a process (ITIMER_REAL); others stay Python's."""

    def __init__(self, turns: Turns) -> None:
        self._turns = turns
        self._interval_ns = 0
        self._signals = 0

    def setitimer(self, which: int, seconds: float, interval: float = 0.0) -> tuple[float, float]:
        """Set a timer; answers what was left of the one before, as ``signal.setitimer``."""
        if which != signal.ITIMER_REAL:
            return _setitimer(which, seconds, interval)
        if seconds < 0 or interval < 0:
            raise signal.ItimerError(22, "Invalid argument")
        left = self.getitimer(which)
        self._interval_ns = math.ceil(interval * NS_PER_S)
        self.due_ns = SimTimeNs(self._turns.now_ns + math.ceil(seconds * NS_PER_S)) if seconds else FOREVER
        return left

    def getitimer(self, which: int) -> tuple[float, float]:
        """Time left and interval of a timer, in seconds."""
        if which != signal.ITIMER_REAL:
            return _getitimer(which)
        left_ns = 0 if self.due_ns == FOREVER else max(self.due_ns - self._turns.now_ns, 1)
        return left_ns / NS_PER_S, self._interval_ns / NS_PER_S

    def alarm(self, seconds: int) -> int:
        """Set the timer in whole seconds; answers what was left."""
        left_s, _ = self.setitimer(signal.ITIMER_REAL, int(seconds))
        return math.ceil(left_s)

    def pause(self) -> None:
        """Wait for a signal."""
        seen = self._signals
        self._turns.wait(lambda: self._signals != seen, FOREVER, "a signal")

    def run(self, now_ns: SimTimeNs) -> None:
        """Call the handler of SIGALRM; without one the program ends, as by the signal."""
        self.due_ns = SimTimeNs(self.due_ns + self._interval_ns) if self._interval_ns else FOREVER
        if self.due_ns <= now_ns:
            self.due_ns = SimTimeNs(now_ns + self._interval_ns)
        self._signals += 1
        handler = signal.getsignal(signal.SIGALRM)
        if callable(handler):
            frame: FrameType | None = None
            handler(signal.SIGALRM, frame)
        elif handler != signal.SIG_IGN:
            os.kill(os.getpid(), signal.SIGALRM)
