"""What a port is to the rest of the daemon, and the daemon to a port.

A port is where bytes enter: a pty, a tcp listener. It moves bytes and counts them; it knows no
device and no simulated time. Everything here runs on the daemon's event loop, in its thread.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from hil.vocab.firmware import NETWORK


def port_label(device: str, key: str) -> str:
    """A port's name: the device's, and for any but its first serial interface ``.network``."""
    return f"{device}.{key}" if key == NETWORK else device


Tap = Callable[[str, bytes], None]
"""Is told what passes at a port: whereto, "board" or "client", and the bytes."""


@dataclass(frozen=True)
class PortContext:
    """Where a port may put things. ``device`` is the device's name (``m1``), for its second serial interface
    ``s1.network``."""

    bench: str
    device: str
    runtime_dir: Path
    """The bench's own runtime directory; stable names (symlinks) live here."""
    group: str | None = None
    """Group for what a port shows to other users, where its own options name none."""


@dataclass(frozen=True)
class PortStats:
    """Counters since the port was opened; exact."""

    clients: int
    """Clients that have the port open now."""
    connects: int
    """Clients that ever opened it."""
    rx_bytes: int
    """Bytes that came from clients and were handed to the device."""
    tx_bytes: int
    """Bytes that were handed to the operating system for clients."""
    dropped_bytes: int
    """Bytes of the device that no client got, because one that has the port open does not read."""
    unheard_bytes: int
    """Bytes of the device that were dropped because nobody had the port open."""
    turned_away: int = 0
    """Clients that found no place, and times that none could be made."""
    away: str | None = None
    """Of a port that is a client itself: why nobody is there, in the system's words."""


class PortHost(Protocol):
    """What a port may call: the session that joins it to its device."""

    def received(self, data: bytes) -> None:
        """Bytes from a client, in order, as they came. Never more than ``room()``."""

    def room(self) -> int:
        """How many bytes the device can take now. At 0 the port stops reading its clients until
        ``Port.resume_reading``, so that a client is held up as a USB host is, and nothing is lost."""

    def drained(self) -> None:
        """What waited for a slow client has gone: ``Port.backlog`` is 0 again."""

    def client_left(self, baud: int | None) -> None:
        """The last client has closed the port; ``baud`` as ``Port.client_baud`` said before that. Ports
        whose clients have no baud need not tell."""

    def port_failed(self, reason: str) -> None:
        """The port cannot go on (its file descriptor is dead). Called once."""


class Port(Protocol):
    """One door for bytes. Made by the ``make`` function of ``virtual_ports/<kind>/port.py``."""

    @property
    def address(self) -> str:
        """What a user types to reach it: a path, or a ``socket://`` URL. Valid after ``open``."""

    async def open(self, host: PortHost) -> None:
        """Make the port reachable. Raises PortError: it cannot be opened, with what to do about it."""

    def write(self, data: bytes) -> None:
        """Bytes of the device, due now. Never blocks; what does not fit is counted as dropped."""

    def resume_reading(self) -> None:
        """The device has room again."""

    def backlog(self) -> int:
        """Bytes of the device that wait for a client to read. The device is held up by it, as a
        board is whose host does not read; only past the port's own limit are bytes dropped."""

    def client_baud(self) -> int | None:
        """The baud a client has set, or None where that means nothing or none was chosen."""

    def stats(self) -> PortStats:
        """Counters now."""

    async def close(self) -> None:
        """Leave nothing behind: no file descriptor, symlink or task. Safe to call twice."""


class PortError(Exception):
    """A port could not be opened: ``str(error)`` says which, why, and the remedy, in one line."""
