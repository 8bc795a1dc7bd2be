"""The daemon as a service: what systemd is told, and when."""

import asyncio
import os
import time
from typing import TYPE_CHECKING

from hil.host.notify import Heartbeat, Notifier, Throttle

if TYPE_CHECKING:
    from hil.daemon import Daemon

STATUS_S = 1.0
"""Between two looks at the line that ``systemctl status`` shows."""
_NAMED = 5


class Service:
    """Of one daemon. All of it runs in the event loop, so that a loop that hangs pings no more."""

    def __init__(self, daemon: "Daemon", notifier: Notifier) -> None:
        self._daemon = daemon
        self._notifier = notifier
        self._heartbeat = Heartbeat()
        self._throttle = Throttle(round(STATUS_S * 1e9))
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self.trouble = ""
        """What the last reload was refused for, in short."""
        daemon.changes.around_reloads(self.reloading, self.reloaded)

    @property
    def is_watched(self) -> bool:
        """A service manager started this daemon."""
        return bool(self._notifier)

    def start(self) -> None:
        """Everything serves."""
        if not self._notifier:
            return
        self._say_ready()
        self._tell()
        if self._notifier.watchdog_ns:
            self._ping()

    def reloading(self) -> None:
        """A reload begins."""
        self._notifier.reloading(time.monotonic_ns())

    def reloaded(self, trouble: str) -> None:
        """It has ended; ``trouble``: why nothing was changed, in a line, or nothing."""
        self.trouble = trouble
        if self._notifier:
            self._say_ready()

    def stop(self) -> None:
        """The daemon ends."""
        for timer in self._timers.values():
            timer.cancel()
        self._notifier.stopping()

    def _say_ready(self) -> None:
        text = status_line(self._daemon, self.trouble)
        self._throttle.due(text, time.monotonic_ns())
        self._notifier.ready(text)

    def _tell(self) -> None:
        text = status_line(self._daemon, self.trouble)
        if self._throttle.due(text, time.monotonic_ns()):
            self._notifier.status(text)
        self._timers["status"] = asyncio.get_running_loop().call_later(STATUS_S, self._tell)

    def _ping(self) -> None:
        if self._heartbeat.beats(self._daemon.bench.core.native.rt_stats()["ticks"]):
            self._notifier.ping()
        elif self._heartbeat.has_stopped:
            self._notifier.trigger()
        self._timers["ping"] = asyncio.get_running_loop().call_later(self._notifier.ping_s, self._ping)


def has_terminal() -> bool:
    """Whether a terminal controls this process: then SIGHUP says that it has gone."""
    try:
        os.close(os.open("/dev/tty", os.O_RDWR | os.O_NOCTTY | os.O_CLOEXEC))
    except OSError:
        return False
    return True


def status_line(daemon: "Daemon", trouble: str) -> str:
    """The bench in one line: devices and those that have failed, clients, real time, missed ticks."""
    failed = [name for name, device in daemon.bench.devices.items() if device.failed]
    failed += [label for label, joint in daemon.places.uarts().items() if joint.failure]
    clients = sum(joint.port.stats().clients for joint in daemon.places.joints())
    missed = daemon.bench.core.native.rt_stats()["missed"]
    parts = [
        f"bench {daemon.config.bench}",
        _counted(len(daemon.config.devices), "device")
        + (f", {len(failed)} failed ({_names(failed)})" if failed else ""),
        _counted(clients, "client"),
        f"real time {daemon.grant.state if daemon.grant else 'starting'}"
        + (f" (no {' and no '.join(daemon.grant.missing)})" if daemon.grant and daemon.grant.missing else ""),
        _counted(missed, "missed tick"),
    ]
    return "; ".join(parts + ([f"reload refused: {trouble}"] if trouble else []))


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _names(names: list[str]) -> str:
    return ", ".join(names[:_NAMED]) + (", ..." if len(names) > _NAMED else "")
