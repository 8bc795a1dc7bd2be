"""Who may come in at the control socket: some 64 at a time; those who say nothing give way to others."""

import asyncio
import logging
import socket
from collections.abc import Awaitable, Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from hil.vocab.acceptor import ACCEPT_AGAIN_S, Acceptor
from hil.vocab.limits import Limit

MAX_CLIENTS = 64
_BACKLOG = 128
_GONE_AFTER_S = 0.002  # a client that was let go has closed its file

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
    """A listening unix socket."""

    def __init__(self, path: Path, serve: Serve, line_limit: int) -> None:
        """``serve`` is run for each client; what it waits for ends with an error when the client has to go.

        Raises:
            OSError: the socket cannot be made.
        """
        self._serve = serve
        self._line_limit = line_limit
        self._loop = asyncio.get_running_loop()
        self._visits: set[Visit] = set()
        self._full = Limit(log.warning, self._loop.call_later)
        self._no_file = Limit(log.warning, self._loop.call_later)
        listener = socket.socket(socket.AF_UNIX)
        try:
            listener.bind(str(path))
            listener.listen(_BACKLOG)
        except OSError:
            listener.close()
            raise
        listener.setblocking(False)
        self._acceptor = Acceptor(listener, self._loop, self._take, self._wait)

    def _take(self, connection: socket.socket) -> None:
        if not self._make_room():
            connection.close()
            return
        visit = Visit(self._loop.time())
        self._visits.add(visit)
        visit.task = self._loop.create_task(self._stay(connection, visit))
        visit.task.add_done_callback(partial(self._has_gone, connection, visit))

    def _wait(self, why: str) -> float:
        self._no_file.reached(f"control socket: new clients have to wait: {why}")
        return _GONE_AFTER_S if self._let_go() else ACCEPT_AGAIN_S

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
        self._acceptor.close()
        self._full.close()
        self._no_file.close()
