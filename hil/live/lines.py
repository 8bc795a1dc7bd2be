"""Paced lines: each byte has a time at which a client's UART has it."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs

_MIN_RELEASE_S = 0.0005  # asyncio's timers are no finer; bytes due sooner go together


class PacedLine(Protocol):
    """End whose bytes have times."""

    def flush(self) -> None:
        """Put what was sent on the line."""

    def release(self, now_ns: SimTimeNs) -> SimTimeNs:
        """Hand the port what is complete by ``now_ns``; answers when the next is due."""

    def refresh(self) -> None:
        """Let the port read on if it was held up and there is room again."""


@dataclass(eq=False)
class PacedLines:
    """Paced lines of a bench: of hundreds, only those with something on them cost time. ``now_ns``: the
    bench's time, which goes ``speed`` times as fast as the wall's."""

    loop: asyncio.AbstractEventLoop
    now_ns: Callable[[], SimTimeNs]
    speed: float = 1.0
    stands: Callable[[], bool] = lambda: False
    """Answers whether time stands."""
    _is_handing_on: bool = field(default=False, init=False)
    _waits: bool = field(default=False, init=False)
    """True if something is due when time goes on."""
    _timer: asyncio.TimerHandle | None = field(default=None, init=False)
    _fresh: list[PacedLine] = field(default_factory=list, init=False)
    """Lines that have sent something since the last ``flush``."""
    _busy: dict[PacedLine, None] = field(default_factory=dict, init=False)
    _held: dict[PacedLine, None] = field(default_factory=dict, init=False)

    def has_sent(self, line: PacedLine) -> None:
        """Note that a line has something to ``flush`` when the present turn is over."""
        self._fresh.append(line)

    def schedule(self, line: PacedLine) -> None:
        """Note that a line has something to do at a time that its ``release`` says."""
        self._busy[line] = None
        self._release()

    def hold(self, line: PacedLine, is_held: bool) -> None:
        """Keep a line's port from reading for now, or no more."""
        if is_held:
            self._held[line] = None
        else:
            self._held.pop(line, None)

    def turn_over(self) -> None:
        """Note that firmware may have run: soon, once for all turns until then, what it sent goes on, and
        ports read what it has room for."""
        if (self._fresh or self._held or self._waits) and not self._is_handing_on:
            self._is_handing_on = True
            self.loop.call_soon(self._hand_on)

    def _hand_on(self) -> None:
        self._is_handing_on = False
        if self._waits:
            self._release()
        self.flush()
        self.refresh()

    def flush(self) -> None:
        if self._fresh:
            fresh, self._fresh = self._fresh, []
            for line in fresh:
                line.flush()
                self._busy[line] = None
            self._release()

    def refresh(self) -> None:
        for line in list(self._held):
            line.refresh()

    def release(self, now_ns: SimTimeNs) -> SimTimeNs:
        """Hand ports what is complete by ``now_ns``; answers when the next is due."""
        next_ns = FOREVER
        for line in list(self._busy):
            if (due_ns := line.release(now_ns)) == FOREVER:
                self._busy.pop(line, None)
            next_ns = min(next_ns, due_ns)
        return next_ns

    def _release(self) -> None:
        """Release what is due now, and set the timer for the next bytes."""
        self.close()
        now_ns = self.now_ns()
        due_ns = self.release(now_ns)
        self._waits = due_ns < FOREVER and self.stands()
        if due_ns < FOREVER and not self._waits:
            delay_s = (due_ns - now_ns) / NS_PER_S / self.speed
            self._timer = self.loop.call_later(max(delay_s, _MIN_RELEASE_S), self._release)

    def close(self) -> None:
        """Release nothing more by time."""
        if self._timer:
            self._timer.cancel()
            self._timer = None

    def forget(self, line: PacedLine) -> None:
        """Remove a line: what is on it is lost."""
        self._busy.pop(line, None)
        self._held.pop(line, None)
        self._fresh = [each for each in self._fresh if each is not line]
