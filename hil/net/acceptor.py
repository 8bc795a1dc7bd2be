"""Taking clients in at a listening socket. Asyncio's own server would log a hundred errors at a time, without
end, while no file descriptor is left."""

from collections.abc import Callable
from typing import Any, Generic, Protocol, TypeVar

from hil.net.limits import Timer

ACCEPT_AGAIN_S = 1.0
_ACCEPTS_AT_ONCE = 16  # a flood of them must not hold up the boards

Connection_co = TypeVar("Connection_co", covariant=True)


class Listener(Protocol[Connection_co]):
    """A socket that listens and does not block."""

    def accept(self) -> tuple[Connection_co, Any]:
        """The next client, and where it is."""

    def close(self) -> None:
        """Listen no more."""


class Loop(Protocol):
    """What is needed of an event loop."""

    def add_reader(self, fd: Any, callback: Callable[[], None]) -> None:
        """Call when there is something to read."""

    def remove_reader(self, fd: Any) -> object:
        """Do not call any more."""

    def call_later(self, delay: float, callback: Callable[[], None]) -> Timer:
        """Call in so many seconds."""


class Acceptor(Generic[Connection_co]):
    """``take`` gets each client. ``no_file`` is told why none can be accepted now, and answers after how many
    seconds to try again: no file descriptor or memory is left, and the listener stays readable. The listener
    is closed with this."""

    def __init__(
        self,
        listener: Listener[Connection_co],
        loop: Loop,
        take: Callable[[Connection_co], None],
        no_file: Callable[[str], float],
    ) -> None:
        self._listener = listener
        self._loop = loop
        self._take = take
        self._no_file = no_file
        self._timer: Timer | None = None
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
        """Let nobody in any more."""
        if self._timer:
            self._timer.cancel()
        self._loop.remove_reader(self._listener)
        self._listener.close()
