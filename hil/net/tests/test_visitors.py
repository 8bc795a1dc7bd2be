"""Admission of clients: who is let in, who gives way, and what is logged of it."""

import socket
from collections.abc import Callable, Coroutine
from typing import Any

import pytest

from hil.net.acceptor import ACCEPT_AGAIN_S
from hil.net.visitors import NO_ROOM, Visit, Visitors

MOST = 3


class FakeTask:
    def __init__(self, stay: Coroutine[Any, Any, None]) -> None:
        self.stay = stay
        self.callbacks: list[Callable[[Any], object]] = []

    def cancel(self) -> None:
        self.stay.close()
        for callback in self.callbacks:
            callback(self)

    def add_done_callback(self, callback: Callable[[Any], object], /) -> None:
        self.callbacks.append(callback)


class FakeLoop:
    """Event loop whose ``now_s`` is set by hand, and whose ``tasks`` run when they are told to."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.tasks: list[FakeTask] = []
        self.readers: list[Callable[[], None]] = []
        self.timers: list[tuple[float, Callable[[], None]]] = []

    def time(self) -> float:
        return self.now_s

    def create_task(self, stay: Coroutine[Any, Any, None]) -> FakeTask:
        self.tasks.append(FakeTask(stay))
        return self.tasks[-1]

    def add_reader(self, fd: Any, callback: Callable[[], None]) -> None:
        self.readers.append(callback)

    def remove_reader(self, fd: Any) -> None:
        self.readers.clear()

    def call_later(self, delay: float, callback: Callable[[], None]) -> "FakeLoop":
        self.timers.append((delay, callback))
        return self

    def cancel(self) -> None:
        """Ignored: a timer's ``cancel``."""


class FakeConnection:
    is_closed = False

    def close(self) -> None:
        self.is_closed = True


class FakeListener(FakeConnection):
    """Listener that has no file descriptor left for a client."""

    def accept(self) -> tuple[FakeConnection, Any]:
        raise OSError(24, "Too many open files")

    def fileno(self) -> int:
        return 0  # of the tests it is always readable: somebody waits


class House:
    """Visitors by the names of their connections."""

    def __init__(self) -> None:
        self.loop = FakeLoop()
        self.said: list[str] = []
        self.visits: dict[FakeConnection, Visit] = {}
        self.visitors = Visitors("house", MOST, self.loop, self._stay, self.said.append)

    async def _stay(self, connection: FakeConnection, visit: Visit) -> None:
        self.visits[connection] = visit

    def comes(self, *, begins: bool = True) -> FakeConnection:
        self.loop.now_s += 1
        connection = FakeConnection()
        self.visitors.admit(connection)
        if begins and not connection.is_closed:
            with pytest.raises(StopIteration):
                self.loop.tasks[-1].stay.send(None)
        return connection

    def inside(self) -> list[FakeConnection]:
        return [connection for connection, visit in self.visits.items() if visit in self.visitors.visits]


def test_who_has_said_nothing_longest_gives_way() -> None:
    house = House()
    first, second, third = house.comes(), house.comes(), house.comes()
    house.visits[first].has_asked = True
    fourth = house.comes()
    assert house.inside() == [first, third, fourth], "the second: the first has asked"
    house.visits[third].has_asked = house.visits[fourth].has_asked = True
    house.visits[first].since_s = 10.0
    fifth = house.comes()
    assert house.inside() == [first, fourth, fifth], "the third was answered before the first"
    assert second not in house.inside()
    assert house.said == ["house: 3 clients are connected; who has said nothing longest is let go"]
    assert house.visitors.turned_away == 2


def test_when_all_are_busy_nobody_is_let_in() -> None:
    house = House()
    for _ in range(MOST):
        house.visits[house.comes()].is_busy = True
    assert house.comes().is_closed
    assert (len(house.inside()), house.visitors.turned_away) == (MOST, 1)
    assert not house.visitors.let_go()


def test_who_finds_all_busy_gets_the_refusal_and_its_end() -> None:
    house = House()
    house.visitors.refusal = NO_ROOM
    for _ in range(MOST):
        house.visits[house.comes()].is_busy = True
    ours, client = socket.socketpair()
    with client:
        house.visitors.admit(ours)
        client.sendall(b"GET / HTTP/1.1\r\n\r\n")
        house.loop.timers[-1][1]()
        head, _, body = client.recv(1000).partition(b"\r\n\r\n")
        assert client.recv(1) == b"", "no reset"
    assert head.startswith(b"HTTP/1.1 503 ")
    assert b"Content-Length: %d" % len(body) in head


def test_who_is_let_go_before_it_was_served_is_hung_up_on() -> None:
    house = House()
    waiting = house.comes(begins=False)
    assert house.visitors.let_go()
    assert waiting.is_closed
    assert not house.visitors.visits
    served = house.comes()
    assert house.visitors.let_go()
    assert not served.is_closed, "whoever serves it does that"


def test_without_a_file_it_is_tried_again_soon_if_somebody_goes() -> None:
    house = House()
    house.visitors.listen(FakeListener())
    (accept,) = house.loop.readers
    accept()
    told, again = house.loop.timers[0][0], house.loop.timers[1]
    assert (told, again[0]) == (60.0, ACCEPT_AGAIN_S)
    house.comes()
    again[1]()
    house.loop.readers[0]()
    assert house.loop.timers[-1][0] == 0.002
    assert not house.visitors.visits
    assert house.said == ["house: new clients have to wait: Too many open files"]


def test_all_are_sent_away_at_the_end() -> None:
    house = House()
    waiting = [house.comes(begins=False) for _ in range(MOST)]
    assert len(house.visitors.send_away()) == MOST
    assert all(connection.is_closed for connection in waiting)
    house.visitors.close()
