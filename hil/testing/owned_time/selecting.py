"""``select``, ``selectors`` and ``socket`` of a program on simulated time.

What is ready is asked of Linux, without waiting; in between, others run and time passes. Descriptors of a
bench's ports, and those whose other end is in the program, are of simulated time; all others are outside.
"""

import functools
import os
import select as real_select
import selectors
import socket
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

from hil.testing.owned_time.owned_locks import until_ns
from hil.testing.owned_time.turns import Turns

_select, _poll, _epoll = real_select.select, real_select.poll, real_select.epoll
_socketpair = socket.socketpair
_fstat, _pipe, _read = os.fstat, os.pipe, os.read
_STDERR = 2
_BLOCKING = ("accept", "recv", "recv_into", "recvfrom", "recvfrom_into", "recvmsg")


class Selecting:
    """Waits for descriptors. ``port_fds``: those of the bench's ports now."""

    def __init__(self, turns: Turns, port_fds: Callable[[], set[int]]) -> None:
        self._turns, self._port_fds = turns, port_fds
        self._inside = set[tuple[int, int]]()
        """Pipes and pairs of sockets whose ends the program has, by device and inode."""

    def _add(self, *fds: int) -> None:
        self._inside.update((each.st_dev, each.st_ino) for each in map(_fstat, fds))

    def _is_inside(self, fd: int) -> bool:
        with suppress(OSError):
            file = _fstat(fd)
            return (file.st_dev, file.st_ino) in self._inside
        return True  # it is closed, which ends the wait

    def wait(
        self,
        look: Callable[[], Any],
        timeout_s: float | None,
        fds: Iterable[int],
        is_found: Callable[[Any], bool] = bool,
    ) -> Any:
        """Look, without waiting for it, until something is found, or the time-out is over."""
        found = look()
        if is_found(found):
            return found
        if timeout_s == 0:
            self._turns.look()
            return look()

        def ready() -> bool:
            nonlocal found
            try:
                found = look()
            except (OSError, ValueError):  # closed by another thread, which runs this: the waiter is told
                is_closed.append(True)
            return bool(is_closed) or is_found(found)

        is_closed = list[bool]()
        is_outside = not all(map(self._is_inside, {*fds} - self._port_fds()))
        self._turns.wait(ready, until_ns(self._turns, timeout_s), "a descriptor", is_outside=is_outside)
        return look() if is_closed else found

    # ---- select ----

    def select(self, reads: Any, writes: Any, errors: Any, timeout: float | None = None) -> Any:
        """``select.select``."""
        if timeout is not None and timeout < 0:
            raise ValueError("timeout must be non-negative")
        lists = [*reads], [*writes], [*errors]
        fds = [each if isinstance(each, int) else each.fileno() for some in lists for each in some]
        return self.wait(lambda: _select(*lists, 0), timeout, fds, any)

    def socketpair(self, *options: Any, **named: Any) -> tuple[socket.socket, socket.socket]:
        """``socket.socketpair``: both ends are in the program."""
        pair = _socketpair(*options, **named)
        self._add(*(each.fileno() for each in pair))
        return pair

    def pipe(self) -> tuple[int, int]:
        """``os.pipe``: both ends are in the program."""
        ends = _pipe()
        self._add(*ends)
        return ends

    def read(self, fd: int, length: int) -> bytes:
        """``os.read``, which waits at the program's own pipes."""
        if self._inside and length and fd > _STDERR and self._is_inside(fd) and os.get_blocking(fd):
            self.wait(lambda: _select([fd], [], [], 0)[0], None, [fd])
        return _read(fd, length)

    def of_select(self) -> dict[str, Any]:
        """Names of ``select``."""
        selecting = self

        class Poll:
            """``select.poll``."""

            def __init__(self, *options: Any) -> None:
                self._poll: Any = self._made(*options)
                self._fds = dict[int, int]()

            _made: Callable[..., Any] = staticmethod(_poll)
            _per_s = 1000.0

            def __getattr__(self, name: str) -> Any:
                return getattr(self._poll, name)

            def __enter__(self) -> "Poll":
                return self

            def __exit__(self, *_: object) -> None:
                self._poll.close()

            def register(self, fd: Any, *mask: int) -> None:
                self._poll.register(fd, *mask)
                number = fd if isinstance(fd, int) else fd.fileno()
                self._fds[number] = number

            def unregister(self, fd: Any) -> None:
                self._poll.unregister(fd)
                self._fds.pop(fd if isinstance(fd, int) else fd.fileno(), None)

            def poll(self, timeout: float | None = None, maxevents: int = -1) -> Any:
                limit_s = None if timeout is None or timeout < 0 else timeout / self._per_s
                return selecting.wait(lambda: self._look(maxevents), limit_s, self._fds)

            def _look(self, maxevents: int) -> Any:
                return self._poll.poll(0)

        class Epoll(Poll):
            """``select.epoll``."""

            _made = staticmethod(_epoll)
            _per_s = 1.0

            def _look(self, maxevents: int) -> Any:
                return self._poll.poll(0, maxevents)

        return {"select": self.select, "poll": Poll, "epoll": Epoll}

    # ---- selectors and sockets ----

    def selector_class(self, base: type[Any]) -> type[Any]:
        """Make a selector of ``selectors`` that waits so."""
        selecting = self

        class Selector(base):  # type: ignore[misc]
            def select(self, timeout: float | None = None) -> Any:
                limit_s = None if timeout is None else max(timeout, 0.0)
                return selecting.wait(
                    lambda: super(Selector, self).select(0),
                    limit_s,
                    [key.fd for key in self.get_map().values()],
                )

        Selector.__name__ = Selector.__qualname__ = base.__name__
        return Selector

    def of_socket(self) -> dict[str, Any]:
        """Methods of ``socket.socket`` that wait for something to come."""
        return {name: self._waiting(getattr(socket.socket, name)) for name in _BLOCKING}

    def _waiting(self, call: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(call)
        def wait_and_call(place: socket.socket, *options: Any, **named: Any) -> Any:
            timeout_s, fd = place.gettimeout(), place.fileno()
            if timeout_s != 0.0 and not self.wait(lambda: _select([fd], [], [], 0)[0], timeout_s, [fd]):
                raise TimeoutError("timed out")
            return call(place, *options, **named)

        return wait_and_call


SELECTORS = tuple(
    getattr(selectors, name)
    for name in ("SelectSelector", "PollSelector", "EpollSelector")
    if hasattr(selectors, name)
)
