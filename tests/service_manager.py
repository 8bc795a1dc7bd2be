"""A service manager for tests: it hears what a daemon says to ``$NOTIFY_SOCKET``."""

import os
import select
import socket
import time
from pathlib import Path

from e2e_support import PATIENCE_S, until


class Manager:
    """Service manager of a test; ``said`` has the messages so far, in order."""

    def __init__(self, folder: Path, watchdog_s: float | None = None) -> None:
        path = folder / "notify"
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(path))
        self._socket.setblocking(False)
        self.said: list[str] = []
        self.env = dict(os.environ) | {"NOTIFY_SOCKET": str(path)}
        if watchdog_s is not None:
            self.env["WATCHDOG_USEC"] = str(round(watchdog_s * 1e6))

    def hear(self) -> list[str]:
        """Messages that have come since the last call."""
        new = []
        while select.select([self._socket], [], [], 0)[0]:
            new.append(self._socket.recv(10_000).decode())
        self.said += new
        return new

    def wait(self, what: str) -> str:
        """Wait until a message with this text comes, or has come already, and return it."""

        def found() -> str | None:
            self.hear()
            return next((message for message in self.said if what in message), None)

        return until(found, repr(what)) or ""

    def pings_in(self, for_s: float) -> int:
        """Number of pings that come in the next ``for_s`` seconds."""
        self.hear()
        end, count = time.monotonic() + for_s, 0
        while (left := end - time.monotonic()) > 0:
            select.select([self._socket], [], [], left)
            count += sum(message == "WATCHDOG=1" for message in self.hear())
        return count

    def next_ping(self, within_s: float = PATIENCE_S) -> float:
        """Wait for the next ping, and return the seconds until it came."""
        self.hear()
        began = time.monotonic()
        until(lambda: "WATCHDOG=1" in self.hear(), "a ping", within_s)
        return time.monotonic() - began

    def close(self) -> None:
        self._socket.close()
