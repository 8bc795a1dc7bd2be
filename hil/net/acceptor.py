"""Taking clients in at a listening socket. Asyncio's own server would log a hundred errors at a time, without
end, while no file descriptor is left."""

import asyncio
import socket
from collections.abc import Callable

ACCEPT_AGAIN_S = 1.0
_ACCEPTS_AT_ONCE = 16  # a flood of them must not hold up the boards


class Acceptor:
    """``take`` gets each client. ``no_file`` is told why none can be accepted now, and answers after how many
    seconds to try again: no file descriptor or memory is left, and the listener stays readable. The listener
    is closed with this."""

    def __init__(
        self,
        listener: socket.socket,
        loop: asyncio.AbstractEventLoop,
        take: Callable[[socket.socket], None],
        no_file: Callable[[str], float],
    ) -> None:
        self._listener = listener
        self._loop = loop
        self._take = take
        self._no_file = no_file
        self._timer: asyncio.TimerHandle | None = None
        loop.add_reader(listener, self.accept)

    def accept(self) -> None:
        """Those who wait, some at a time."""
        for _ in range(_ACCEPTS_AT_ONCE):
            try:
                connection, _ = self._listener.accept()
            except BlockingIOError:
                return
            except ConnectionError:
                continue  # it hung up while it was waiting
            except OSError as error:
                self._loop.remove_reader(self._listener)
                delay_s = self._no_file(error.strerror or str(error))
                self._timer = self._loop.call_later(delay_s, self._again)
                return
            self._take(connection)

    def _again(self) -> None:
        self._timer = None
        self._loop.add_reader(self._listener, self.accept)

    def close(self) -> None:
        if self._timer:
            self._timer.cancel()
        self._loop.remove_reader(self._listener)
        self._listener.close()
