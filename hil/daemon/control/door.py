"""Who may come in at the control socket: some 64 at a time; those who say nothing give way to others."""

import asyncio
import logging
import socket
from collections.abc import Awaitable, Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from hil.vocab.limits import Limit

MAX_CLIENTS = 64
_BACKLOG = 128
_ACCEPT_AGAIN_S = 1.0
_GONE_AFTER_S = 0.002  # a client that was let go has closed its file
_ACCEPTS_AT_ONCE = 16  # a flood of them must not hold up the boards

log = logging.getLogger("hil")


@dataclass(eq=False)
class Visit:
    """A client's stay. Whoever serves it says what it is doing."""

    since_s: float
    """When it came, or was answered last: of the event loop's clock."""
    is_busy: bool = False
    """It waits for an answer, or has a capture: it is not let go."""
    has_asked: bool = False
    task: "asyncio.Task[None] | None" = None
    has_begun: bool = False
    """The task has the connection."""


Serve = Callable[[asyncio.StreamReader, asyncio.StreamWriter, Visit], Awaitable[None]]


class ControlDoor:
    """A listening unix socket. Asyncio's own server would log a hundred errors at a time, without end, while
    no file descriptor is left."""

    def __init__(self, path: Path, serve: Serve, line_limit: int) -> None:
        """``serve`` is run for each client; what it waits for ends with an error when the client has to go.

        Raises:
            OSError: the socket cannot be made.
        """
        self._serve = serve
        self._line_limit = line_limit
        self._loop = asyncio.get_running_loop()
        self._visits: set[Visit] = set()
        self._timer: asyncio.TimerHandle | None = None
        self._full = Limit(log.warning, self._loop.call_later)
        self._no_file = Limit(log.warning, self._loop.call_later)
        self._listener = socket.socket(socket.AF_UNIX)
        try:
            self._listener.bind(str(path))
            self._listener.listen(_BACKLOG)
        except OSError:
            self._listener.close()
            raise
        self._listener.setblocking(False)
        self._loop.add_reader(self._listener, self._accept)

    def _accept(self) -> None:
        for _ in range(_ACCEPTS_AT_ONCE):
            try:
                connection, _ = self._listener.accept()
            except BlockingIOError:
                return
            except ConnectionError:
                continue  # it hung up while it was waiting
            except OSError as error:
                # No fd or memory is left, and the listener stays readable: try again when some may be.
                self._no_file.reached(f"control socket: new clients have to wait: {error.strerror}")
                self._loop.remove_reader(self._listener)
                delay_s = _GONE_AFTER_S if self._let_go() else _ACCEPT_AGAIN_S
                self._timer = self._loop.call_later(delay_s, self._accept_again)
                return
            if not self._make_room():
                connection.close()
                continue
            visit = Visit(self._loop.time())
            self._visits.add(visit)
            visit.task = self._loop.create_task(self._stay(connection, visit))
            visit.task.add_done_callback(partial(self._has_gone, connection, visit))

    def _accept_again(self) -> None:
        self._timer = None
        self._loop.add_reader(self._listener, self._accept)

    def _make_room(self) -> bool:
        if len(self._visits) < MAX_CLIENTS:
            return True
        self._full.reached(
            f"control socket: {MAX_CLIENTS} clients are connected; who has said nothing longest is let go"
        )
        return self._let_go()

    def _let_go(self) -> bool:
        """One who is not waiting for anything, if there is one: of those who never asked, the first."""
        idle = [visit for visit in self._visits if not visit.is_busy]
        if not idle:
            return False
        gone = min(idle, key=lambda visit: (visit.has_asked, visit.since_s))
        self._visits.discard(gone)
        if gone.task:
            gone.task.cancel()
        return True

    @staticmethod
    def _has_gone(connection: socket.socket, visit: Visit, task: "asyncio.Task[None]") -> None:
        if not visit.has_begun:  # a task that is cancelled at once never runs
            connection.close()

    async def _stay(self, connection: socket.socket, visit: Visit) -> None:
        visit.has_begun = True
        try:
            try:
                reader, writer = await asyncio.open_unix_connection(sock=connection, limit=self._line_limit)
            except BaseException:
                connection.close()
                raise
            with closing(writer), suppress(ConnectionError):
                await self._serve(reader, writer, visit)
        finally:
            self._visits.discard(visit)

    def close(self) -> None:
        """Let nobody in any more; those who are inside stay."""
        self._loop.remove_reader(self._listener)
        self._listener.close()
        if self._timer:
            self._timer.cancel()
        self._full.close()
        self._no_file.close()
