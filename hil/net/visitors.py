"""Admission control for listening sockets: at most so many clients at a time; idle ones are dropped first. A
limit is logged once when it is reached, and then counted: a flood must not fill the log."""

import asyncio
import socket
from collections import deque
from collections.abc import Callable, Coroutine
from contextlib import suppress
from dataclasses import field

from hil.net.acceptor import ACCEPT_AGAIN_S, Acceptor
from hil.vocab.late_dataclass import dataclass

AGAIN_S = 60.0
"""Minimum time between two log lines on one limit."""


class Limit:
    """Limit. ``count`` is how often it was reached. ``say`` gets a line for the log at once and, if it was
    reached again, one with the number after ``AGAIN_S``."""

    def __init__(self, say: Callable[[str], object], loop: asyncio.AbstractEventLoop) -> None:
        self.count = 0
        self._say = say
        self._loop = loop
        self._timer: asyncio.TimerHandle | None = None
        self._told = 0
        self._text = ""

    def reached(self, text: str) -> None:
        """Count that the limit stopped something: ``text`` says which limit, and what to do."""
        self.count += 1
        self._text = text
        if self._timer is None:
            self._tell(text)

    def _tell(self, text: str) -> None:
        self._say(text)
        self._told = self.count
        self._timer = self._loop.call_later(AGAIN_S, self._later)

    def _later(self) -> None:
        self._timer = None
        if more := self.count - self._told:
            self._tell(f"{self._text} ({more} more in the last {AGAIN_S:g} s)")

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


_REFUSED, _REFUSED_S = 16, 0.2
"""Maximum number of refused connections that stay for a moment, and the moment."""
_READ_BYTES = 65536
NO_ROOM = (
    b"HTTP/1.1 503 Service Unavailable\r\nContent-Type: text/plain\r\nContent-Length: 46\r\n"
    b"Retry-After: 1\r\nConnection: close\r\n\r\nbusy: too many clients are served; ask again.\n"
)
"""Refusal of a door that speaks HTTP."""
_GONE_AFTER_S = 0.002  # a client that was let go has closed its file


@dataclass(eq=False)
class Visit:
    """Stay of a client. Its server notes in it what the client is doing."""

    since_s: float
    """Time at which it came, or was answered last, on the event loop's clock."""
    is_busy: bool = False
    """True while the client waits for an answer, or has something running: it is not let go."""
    has_asked: bool = False
    has_begun: bool = False
    """True once the client's task has the connection."""
    task: asyncio.Task[None] | None = None


@dataclass(eq=False)
class Visitors:
    """Clients of listening sockets. ``stay`` serves each one and closes its connection; it is cancelled where
    it waits when its client has to go. ``name`` begins the lines of the log."""

    name: str
    most: int
    loop: asyncio.AbstractEventLoop
    stay: Callable[[socket.socket, Visit], Coroutine[None, None, None]]
    say: Callable[[str], object]
    refusal: bytes = b""
    """Answer to a client for whom there is no room, before its connection is closed; empty: the protocol has
    none."""
    has_spare: bool = False
    """True keeps a file descriptor for one more client when all others are in use."""
    turned_away: int = field(default=0, init=False)
    """Number of clients that were let go, or not let in."""
    visits: dict[Visit, None] = field(default_factory=dict, init=False)
    """Clients that are inside, in the order in which they came."""
    _refused: deque[socket.socket] = field(default_factory=deque, init=False)
    _acceptors: list[Acceptor] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self._full, self._no_file = Limit(self.say, self.loop), Limit(self.say, self.loop)

    def listen(self, listener: socket.socket) -> None:
        """Let clients in at this socket, too."""
        self._acceptors.append(Acceptor(listener, self.loop, self.admit, self._wait, self.has_spare))

    def admit(self, connection: socket.socket) -> None:
        """Serve a client, or refuse it."""
        if not self._make_room():
            self.turned_away += 1
            self._refuse(connection)
            return
        visit = Visit(self.loop.time())
        self.visits[visit] = None
        visit.task = task = self.loop.create_task(self._begin(connection, visit))

        def has_gone(_: object) -> None:
            self.visits.pop(visit, None)
            if not visit.has_begun:  # a task that is cancelled at once never runs
                connection.close()

        task.add_done_callback(has_gone)

    def _refuse(self, connection: socket.socket) -> None:
        """Hang up with the refusal. The connection stays for a moment: its client may be about to ask, and
        could not even write to a closed one."""
        if not self.refusal or len(self._refused) >= _REFUSED:
            connection.close()
            return
        with suppress(OSError):
            connection.setblocking(False)
            connection.send(self.refusal)
        self._refused.append(connection)
        self.loop.call_later(_REFUSED_S, self._hang_up)

    def _hang_up(self) -> None:
        """End the connection that was refused first. What its client has sent is read: closed with that in
        it, the connection would be reset, and the refusal could be lost."""
        if self._refused:
            connection = self._refused.popleft()
            with suppress(OSError):
                connection.recv(_READ_BYTES)
            connection.close()

    async def _begin(self, connection: socket.socket, visit: Visit) -> None:
        visit.has_begun = True
        await self.stay(connection, visit)

    def _wait(self, why: str) -> float:
        self._no_file.reached(f"{self.name}: new clients have to wait: {why}")
        return _GONE_AFTER_S if self.let_go() else ACCEPT_AGAIN_S

    def _make_room(self) -> bool:
        if len(self.visits) < self.most:
            return True
        self._full.reached(
            f"{self.name}: {self.most} clients are connected; who has said nothing longest is let go"
        )
        return self.let_go()

    def let_go(self) -> bool:
        """Drop a client that waits for nothing, if there is one: of those who never asked, the first."""
        idle = [visit for visit in self.visits if not visit.is_busy]
        if not idle:
            return False
        gone = min(idle, key=lambda visit: (visit.has_asked, visit.since_s))
        del self.visits[gone]
        self.turned_away += 1
        if gone.task:
            gone.task.cancel()
        return True

    def send_away(self) -> list[asyncio.Task[None]]:
        """Drop all clients. Answers the tasks that end now."""
        tasks = [visit.task for visit in self.visits if visit.task]
        for task in tasks:
            task.cancel()
        return tasks

    def close(self) -> None:
        """Let nobody in any more; clients that are inside stay."""
        for acceptor in self._acceptors:
            acceptor.close()
        while self._refused:
            self._hang_up()
        self._full.close()
        self._no_file.close()
