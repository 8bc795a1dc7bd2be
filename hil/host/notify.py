"""Messages to the service manager that started the daemon (systemd's ``sd_notify`` protocol), and when it is
told that all is well. Without ``$NOTIFY_SOCKET`` nothing is sent.

A message is a datagram of lines ``NAME=value`` to a unix socket (sd_notify(3)); a watchdog that does not hear
``WATCHDOG=1`` for ``$WATCHDOG_USEC`` ends and restarts the process (sd_watchdog_enabled(3)).
"""

import socket
from collections.abc import Mapping
from dataclasses import dataclass

_PINGS = 16
"""Pings in the watchdog's time. The last one comes up to one interval after the core's last tick."""
_PATIENCE_S = 0.5
"""Maximum wait for a busy manager with what changes the unit's state; all else is said again soon."""
_TEXT_BYTES = 2000


class Notifier:
    """Sender of messages to the service manager. ``env`` is the process's environment; ``pid`` its number."""

    def __init__(self, env: Mapping[str, str], pid: int) -> None:
        address = env.get("NOTIFY_SOCKET", "")
        self._address: str | None = None
        if address.startswith("/"):
            self._address = address
        elif address.startswith("@"):  # an abstract name
            self._address = "\0" + address[1:]
        self.watchdog_ns = self._watchdog_ns(env, pid) if self._address else 0
        """Silence after which this process is taken for hung; 0: nobody watches."""
        # Made now: later there may be no file descriptor left, and that alone must not end the process.
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) if self._address else None

    def close(self) -> None:
        """Send nothing more."""
        self._address = None
        if self._socket:
            self._socket.close()

    @staticmethod
    def _watchdog_ns(env: Mapping[str, str], pid: int) -> int:
        wanted, whose = env.get("WATCHDOG_USEC", ""), env.get("WATCHDOG_PID", str(pid))
        return int(wanted) * 1000 if wanted.isdecimal() and whose == str(pid) else 0

    def __bool__(self) -> bool:
        return self._address is not None

    @property
    def ping_s(self) -> float:
        """Period of the looks at whether to ping."""
        return self.watchdog_ns / 1e9 / _PINGS

    def ready(self, status: str) -> None:
        """Tell that the daemon serves, from the start or again after a reload."""
        self._send("READY=1", _status(status), wait_s=_PATIENCE_S)

    def reloading(self, monotonic_ns: int) -> None:
        """Tell that a reload begins; ``ready`` ends it, whatever became of it."""
        self._send("RELOADING=1", f"MONOTONIC_USEC={monotonic_ns // 1000}", wait_s=_PATIENCE_S)

    def stopping(self) -> None:
        self._send("STOPPING=1", "STATUS=stopping", wait_s=_PATIENCE_S)

    def status(self, text: str) -> None:
        """Tell one line for people, shown by ``systemctl status``."""
        self._send(_status(text))

    def ping(self) -> None:
        self._send("WATCHDOG=1")

    def trigger(self) -> None:
        """Tell that the core has hung for the watchdog's time: the manager need not wait on, rounded up to a
        quarter of a second (systemd's timers). systemd before 243 does not know this, and waits."""
        self._send("WATCHDOG=trigger")

    def _send(self, *lines: str, wait_s: float = 0.0) -> None:
        if self._address is None or self._socket is None:
            return
        try:
            self._socket.settimeout(wait_s)
            self._socket.sendto("\n".join(lines).encode(), self._address)
        except OSError:
            # A manager that is away or does not read: its watchdog decides, not this process.
            return


def _status(text: str) -> str:
    one_line = " ".join(text.split())
    return "STATUS=" + one_line.encode()[:_TEXT_BYTES].decode(errors="ignore")


@dataclass
class Heartbeat:
    """Decision whether to ping: only where the core has moved since the last time. Asked by the event loop,
    which therefore runs."""

    ticks: int = -1
    _still: int = 0

    def beats(self, ticks: int) -> bool:
        """True if the core has moved since the last call, so that a ping is due. ``ticks``: the core's
        counter."""
        moved = ticks != self.ticks
        self.ticks = ticks
        self._still = 0 if moved else self._still + 1
        return moved

    @property
    def has_stopped(self) -> bool:
        """True if the core has not moved in as many looks as the watchdog's time has. Looks, not seconds: a
        process that was stopped as a whole makes none."""
        return self._still >= _PINGS - 1


@dataclass
class Throttle:
    """Throttle of texts that change quickly: the latest, at most once in ``every_ns``."""

    every_ns: int
    said: str = ""
    _said_ns: int | None = None

    def due(self, text: str, now_ns: int) -> bool:
        if text == self.said or (self._said_ns is not None and now_ns - self._said_ns < self.every_ns):
            return False
        self.said, self._said_ns = text, now_ns
        return True
