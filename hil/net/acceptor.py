"""Acceptor of clients at a listening socket. Asyncio's own server would log a hundred errors at a time,
without end, while no file descriptor is left."""

import asyncio
import socket
from collections.abc import Callable
from dataclasses import dataclass, field

ACCEPT_AGAIN_S = 1.0
_ACCEPTS_AT_ONCE = 16  # a flood of them must not hold up the boards


@dataclass(eq=False)
class Acceptor:
    """Acceptor at a listening socket. ``take`` gets each client. ``no_file`` is told why none can be accepted
    now, and answers after how many seconds to try again: no file descriptor or memory is left, and the
    listener stays readable. The listener is closed with this."""

    listener: socket.socket
    loop: asyncio.AbstractEventLoop
    take: Callable[[socket.socket], None]
    no_file: Callable[[str], float]
    _timer: asyncio.TimerHandle | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self.loop.add_reader(self.listener, self.accept)

    def accept(self) -> None:
        """Accept those who wait, some at a time."""
        for _ in range(_ACCEPTS_AT_ONCE):
            try:
                connection, _ = self.listener.accept()
            except BlockingIOError:
                return
            except ConnectionError:
                continue  # it hung up while it was waiting
            except OSError as error:
                self.loop.remove_reader(self.listener)
                delay_s = self.no_file(error.strerror or str(error))
                self._timer = self.loop.call_later(delay_s, self._again)
                return
            self.take(connection)

    def _again(self) -> None:
        self._timer = None
        self.loop.add_reader(self.listener, self.accept)

    def close(self) -> None:
        if self._timer:
            self._timer.cancel()
        self.loop.remove_reader(self.listener)
        self.listener.close()
