"""Acceptor of clients at a listening socket, and the end of a connection at once. Asyncio's own server would
log a hundred errors at a time, without end, while no file descriptor is left."""

import asyncio
import errno
import os
import select
import socket
from collections.abc import Callable
from contextlib import suppress
from dataclasses import field

from hil.vocab.late_dataclass import dataclass

ACCEPT_AGAIN_S = 1.0
SPARE_AGAIN_S = 0.01
NO_FILE = (errno.EMFILE, errno.ENFILE)
_ACCEPTS_AT_ONCE = 16  # a flood of them must not hold up the boards


@dataclass(eq=False)
class Acceptor:
    """Acceptor at a listening socket. ``admit`` gets each client. ``no_file`` is told why none can be taken
    now, and answers after how many seconds to try again: no file descriptor or memory is left, and the
    listener stays readable. ``has_spare``: a file descriptor is kept for one more client. The listener is
    closed with this."""

    listener: socket.socket
    loop: asyncio.AbstractEventLoop
    admit: Callable[[socket.socket], None]
    no_file: Callable[[str], float]
    has_spare: bool = False
    _spare: int = field(default=-1, init=False)
    _timer: asyncio.TimerHandle | None = field(default=None, init=False)
    _spare_timer: asyncio.TimerHandle | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        if self.has_spare:
            self._keep_spare()
        self.loop.add_reader(self.listener, self.accept)

    def accept(self) -> None:
        """Accept those who wait, some at a time."""
        for _ in range(_ACCEPTS_AT_ONCE):
            try:
                connection = self._accepted()
            except BlockingIOError:
                return
            except ConnectionError:
                continue  # it hung up while it was waiting
            except OSError as error:
                if not self._is_asked():
                    return
                self.loop.remove_reader(self.listener)
                delay_s = self.no_file(error.strerror or str(error))
                self._timer = self.loop.call_later(delay_s, self._again)
                return
            self.admit(connection)

    def _accepted(self) -> socket.socket:
        """Accept a client, at last with the spare file descriptor."""
        try:
            return self.listener.accept()[0]
        except OSError as error:
            if error.errno not in NO_FILE or self._spare < 0 or not self._is_asked():
                raise
        os.close(self._spare)
        self._spare = -1
        self._spare_timer = self.loop.call_later(SPARE_AGAIN_S, self._keep_spare)
        return self.listener.accept()[0]

    def _is_asked(self) -> bool:
        """True if somebody waits: without a file descriptor left the system does not look."""
        look = select.poll()
        look.register(self.listener, select.POLLIN)
        return bool(look.poll(0))

    def _keep_spare(self) -> None:
        """Have a spare file descriptor, as soon as there is one: before others accept their next clients."""
        try:
            self._spare = os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
            self._spare_timer = None
        except OSError:
            self._spare_timer = self.loop.call_later(SPARE_AGAIN_S, self._keep_spare)

    def _again(self) -> None:
        self._timer = None
        self.loop.add_reader(self.listener, self.accept)

    def close(self) -> None:
        if self._timer:
            self._timer.cancel()
        if self._spare_timer:
            self._spare_timer.cancel()
        if self._spare >= 0:
            os.close(self._spare)
            self._spare = -1
        self.loop.remove_reader(self.listener)
        self.listener.close()


def abort(transport: asyncio.WriteTransport) -> None:
    """End a connection at once, also one that has ended."""
    # One that was closed while something waited to be sent, and that has sent it, has no loop any more.
    with suppress(AttributeError):
        transport.abort()
