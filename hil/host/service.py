"""Daemon as a service: its messages to systemd, and when they are sent."""

import asyncio
import os
import time
from collections.abc import Callable

from hil.host.notify import Heartbeat, Notifier, Throttle

STATUS_S = 1.0
"""Interval of looks at the line that ``systemctl status`` shows."""


class Service:
    """Reports to a service manager on the bench. ``line``: the bench in one line; ``ticks``: wakes of the
    core. All of it runs in the event loop, so that a loop that hangs pings no more."""

    def __init__(self, notifier: Notifier, line: Callable[[], str], ticks: Callable[[], int]) -> None:
        self._notifier = notifier
        self._line = line
        self._ticks = ticks
        self._heartbeat = Heartbeat()
        self._throttle = Throttle(round(STATUS_S * 1e9))
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self.trouble = ""
        """Reason why the last reload was refused, in short."""

    def start(self) -> None:
        if not self._notifier:
            return
        self._say_ready()
        self._tell()
        if self._notifier.watchdog_ns:
            self._ping()

    def reloading(self) -> None:
        self._notifier.reloading(time.monotonic_ns())

    def reloaded(self, trouble: str) -> None:
        """Tell that the reload has ended; ``trouble``: why nothing was changed, in a line, or nothing."""
        self.trouble = trouble
        if self._notifier:
            self._say_ready()

    def stop(self) -> None:
        for timer in self._timers.values():
            timer.cancel()
        self._notifier.stopping()

    def _text(self) -> str:
        return self._line() + (f"; reload refused: {self.trouble}" if self.trouble else "")

    def _say_ready(self) -> None:
        text = self._text()
        self._throttle.due(text, time.monotonic_ns())
        self._notifier.ready(text)

    def _tell(self) -> None:
        text = self._text()
        if self._throttle.due(text, time.monotonic_ns()):
            self._notifier.status(text)
        self._timers["status"] = asyncio.get_running_loop().call_later(STATUS_S, self._tell)

    def _ping(self) -> None:
        if self._heartbeat.beats(self._ticks()):
            self._notifier.ping()
        elif self._heartbeat.has_stopped:
            self._notifier.trigger()
        self._timers["ping"] = asyncio.get_running_loop().call_later(self._notifier.ping_s, self._ping)


def has_terminal() -> bool:
    """True if a terminal controls this process: then SIGHUP says that it has gone."""
    try:
        os.close(os.open("/dev/tty", os.O_RDWR | os.O_NOCTTY | os.O_CLOEXEC))
    except OSError:
        return False
    return True
