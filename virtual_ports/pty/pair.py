"""Both ends of a pty. The daemon keeps the slave open too, so that clients may come and go."""

import errno
import os
import select
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from virtual_ports.pty import terminal_settings


class PtyPair:
    """A pty that is open, its line at rest. ``died`` is told once that it is dead, as after root's vhangup.

    Raises:
        OSError: the system has no pty left.
    """

    def __init__(self, died: Callable[[OSError], None]) -> None:
        self._died = died
        self.is_dead = False
        self.master, self.slave = os.openpty()
        try:
            self.pts = Path(os.ttyname(self.slave))
            os.set_blocking(self.master, False)
            self._input = select.poll()
            self._input.register(self.master, select.POLLIN)
            self._resting = terminal_settings.resting(self.slave)
            terminal_settings.apply(self.slave, self._resting)
        except OSError:
            self.close()
            raise

    def has_input(self) -> bool:
        """True if clients have written what was not read."""
        return bool(self._input.poll(0))

    def rest(self) -> None:
        """Set the line as it is between two clients.

        Raises:
            OSError: root has locked its settings, or the pty is dead.
        """
        if terminal_settings.is_locked(self.slave):
            raise OSError(errno.EPERM, "its settings are locked")
        terminal_settings.apply(self.slave, self._resting)
        terminal_settings.end_exclusive(self.slave)

    def is_unused(self) -> bool:
        """True if no client has the pty open. The slave is closed for a moment, which the watch sees.

        The kernel shows only whether any slave is open, ours included. Do not ask of one that is exclusive:
        we might not get back in.
        """
        slave, self.slave = self.slave, -1
        os.close(slave)
        hung_up = any(events & select.POLLHUP for _, events in self._input.poll(0))
        self.slave = os.open(self.pts, os.O_RDWR | os.O_NOCTTY | os.O_CLOEXEC)
        return hung_up

    @contextmanager
    def failing_loudly(self) -> Iterator[None]:
        """Treat an error as the pty's death: it must not stop the other ports, which come after this one."""
        try:
            yield
        except OSError as error:
            self.fail(error)

    def fail(self, error: OSError) -> None:
        if not self.is_dead:
            self.is_dead = True
            self._died(error)

    def close(self) -> None:
        """Close both ends. Call it once."""
        os.close(self.master)
        if self.slave >= 0:
            os.close(self.slave)
