"""Looks at a running bench for a port: where it is, and how many programs have it open."""

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from hil.cli.boards.board_access import port_rows
from hil.cli.framework.ask import BenchOptions
from hil.host.trust import refuse_address
from hil.net.benches_here import Here, find
from hil.net.control_client import ControlError, ask
from hil.vocab.port_programs import is_held

LOOK_S, AWAY_LOOK_S = 1.0, 0.25
"""Time between two looks while the port is open, and while it is away."""
_PATIENCE_S = 2.0
_PIECE = 65536


class SeenPort(NamedTuple):
    """Port as a bench has it. ``clients``: number of programs that have it open."""

    address: str
    clients: int
    socket: Path


class NamedPort:
    """Port of a device of the bench that is meant, for as long as somebody wants it."""

    def __init__(self, name: str, options: BenchOptions) -> None:
        self.name = name
        self._options = options
        self._folder: Path | None = None

    def is_of(self, bench: Here) -> None:
        """Look for it on the bench of this folder alone from now on."""
        self._folder = bench.folder

    def look(self) -> SeenPort | None:
        """Look where it is now; None: its bench does not run, or has it no more."""
        here = find(self._options.runtime_dir, os.environ).running()
        if self._folder is None:
            meant = here.meant(self._options.bench)
        else:
            meant = [each for each in here.benches if each.folder == self._folder]
        if len(meant) != 1:
            return None
        try:
            devices = ask(meant[0].socket, "list", timeout_s=_PATIENCE_S)["devices"]
        except ControlError:
            return None
        row = port_rows(devices).get(self.name)
        address = row and row["address"]
        if not row or not address or is_held(row.get("kind", row.get("port"))):
            return None
        if refuse_address(address, meant[0].owner):
            return None
        return SeenPort(address, row["clients"], meant[0].socket)


class PortWatch:
    """Thread that looks again and again, so that a bench that hangs keeps no key waiting. ``fd`` can be read
    when a look is over, whose ``seen`` then holds."""

    def __init__(self, look: Callable[[], SeenPort | None]) -> None:
        self._look = look
        self.fd, self._wake = os.pipe()
        os.set_blocking(self._wake, False)
        self.seen: SeenPort | None = None
        self._is_away, self._is_over, self._turn = False, False, threading.Event()
        self._lock = threading.Lock()
        self._since = 0
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def away(self, is_away: bool) -> None:
        """Look more often while the port is away; what was seen before counts no more."""
        with self._lock:
            self._is_away, self.seen = is_away, None
            self._since += 1
        self._turn.set()

    def take_news(self) -> SeenPort | None:
        """Read what makes ``fd`` readable; answers what was seen last."""
        os.read(self.fd, _PIECE)
        with self._lock:
            return self.seen

    def close(self) -> None:
        """End the thread, when its last look is over."""
        self._is_over = True
        self._turn.set()
        os.close(self.fd)

    def _run(self) -> None:
        try:
            while not self._is_over:
                self._turn.clear()
                if self._has_looked():
                    self._turn.wait(AWAY_LOOK_S if self._is_away else LOOK_S)
        finally:
            os.close(self._wake)

    def _has_looked(self) -> bool:
        """Look; false if what was seen is of a time before ``away``."""
        with self._lock:
            since = self._since
        try:
            seen = self._look()
        except OSError:  # folders come and go
            seen = None
        with self._lock:
            if since != self._since:
                return False
            self.seen = seen
            with suppress(OSError):  # nobody has read the last one, or reads any more
                os.write(self._wake, b"!")
        return True
