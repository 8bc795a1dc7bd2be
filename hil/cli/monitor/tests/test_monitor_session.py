"""A session of a monitor at pseudo-terminals: what goes through, a port that goes and comes, others at it."""

import os
import pty
import select
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from hil.cli.monitor.monitor_session import MonitorSession, ReceivedLog
from hil.cli.monitor.port_look import PortWatch, SeenPort
from hil.cli.monitor.shown_bytes import HexView, PlainView
from hil.cli.monitor.typed_keys import KeyReader

PATIENCE_S = 10.0


class Board:
    """Far end of a port: a pty that can go and come as another."""

    def __init__(self) -> None:
        self.clients = 0
        self.come()

    def come(self) -> None:
        self.fd, inner = pty.openpty()
        self._inner = inner
        self.seen: SeenPort | None = SeenPort(os.ttyname(inner), self.clients, Path("/nowhere"))

    def is_open(self) -> bool:
        """True once a session has opened it: the terminal is raw."""
        return not termios.tcgetattr(self._inner)[tty.LFLAG] & termios.ICANON

    def go(self) -> None:
        self.seen = None
        os.close(self._inner)
        os.close(self.fd)

    def look(self) -> SeenPort | None:
        return self.seen and self.seen._replace(clients=self.clients)


class Terminal:
    """Terminal of a session that runs in a thread."""

    def __init__(self, board: Board, **options: Any) -> None:
        self.fd, self._keyboard = pty.openpty()
        self._read, self._out = os.pipe()
        self.shown = b""
        watch = PortWatch(board.look)
        session = MonitorSession(
            name="m1",
            keys=KeyReader(b"\n", {"1": b"macro"}),
            view=options.pop("view", PlainView()),
            is_typed=True,
            waits=options.pop("waits", True),
            watch=watch,
            keyboard=self._keyboard,
            out=self._out,
            **options,
        )

        def run() -> None:
            session.run(board.look(), ["begun"])
            watch.close()

        self.thread = threading.Thread(target=run, daemon=True)
        self.thread.start()
        until(board.is_open, "the session")

    def shows(self, wanted: bytes) -> bool:
        if select.select([self._read], [], [], 0.02)[0]:
            self.shown += os.read(self._read, 65536)
        return wanted in self.shown

    def type(self, keys: bytes) -> None:
        os.write(self.fd, keys)

    def ends(self) -> bool:
        self.type(b"\x1d")
        self.thread.join(PATIENCE_S)
        return not self.thread.is_alive()


def until(holds: Callable[[], bool], what: str) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end_s, what
        time.sleep(0.01)


def got(fd: int, length: int) -> bytes:
    data = b""
    while len(data) < length and select.select([fd], [], [], PATIENCE_S)[0]:
        data += os.read(fd, length - len(data))
    return data


@pytest.fixture
def board() -> Iterator[Board]:
    made = Board()
    yield made
    if made.seen:
        made.go()


def test_bytes_go_both_ways_and_enter_as_the_board_takes_it(board: Board) -> None:
    terminal = Terminal(board)
    os.write(board.fd, b"hello\n")
    until(lambda: terminal.shows(b"hello\n"), "what came")
    terminal.type(b"p\r\x141")
    assert got(board.fd, 7) == b"p\nmacro"
    assert terminal.ends()


def test_four_kilobytes_are_pasted_whole(board: Board) -> None:
    terminal = Terminal(board)
    pasted = b"".join(b"line %03d of what is pasted\r" % number for number in range(152))
    threading.Thread(target=terminal.type, args=[pasted], daemon=True).start()
    assert got(board.fd, len(pasted)) == pasted.replace(b"\r", b"\n")
    assert terminal.ends()


def test_a_port_that_has_gone_is_waited_for(board: Board, capfd: pytest.CaptureFixture[str]) -> None:
    terminal = Terminal(board)
    os.write(board.fd, b"one")
    until(lambda: terminal.shows(b"one"), "the first bytes")
    board.go()
    said = ""

    def says(text: str) -> bool:
        nonlocal said
        said += capfd.readouterr().err
        return text in said

    until(lambda: says("waiting until it is there"), "that it waits")
    terminal.type(b"lost")
    board.come()
    until(lambda: says("m1 is there, at ") and board.is_open(), "that it is there")
    os.write(board.fd, b"two")
    until(lambda: terminal.shows(b"one\ntwo"), "bytes of the second")
    terminal.type(b"p")
    assert got(board.fd, 1) == b"p"
    assert terminal.ends()


def test_the_key_that_ends_it_ends_the_wait_at_once(board: Board, capfd: pytest.CaptureFixture[str]) -> None:
    terminal = Terminal(board)
    os.write(board.fd, b"one")
    until(lambda: terminal.shows(b"one"), "the first bytes")
    board.go()
    until(lambda: "waiting until" in capfd.readouterr().err, "that it waits")
    begun_s = time.monotonic()
    assert terminal.ends()
    assert time.monotonic() - begun_s < 5


def test_a_port_that_has_gone_ends_it_if_nobody_waits(board: Board) -> None:
    terminal = Terminal(board, waits=False)
    os.write(board.fd, b"one")
    until(lambda: terminal.shows(b"one"), "the first bytes")
    board.go()
    terminal.thread.join(PATIENCE_S)
    assert not terminal.thread.is_alive()


def test_another_program_at_the_port_is_told(board: Board, capfd: pytest.CaptureFixture[str]) -> None:
    terminal = Terminal(board)
    board.clients = 2
    said = ""

    def says(text: str) -> bool:
        nonlocal said
        said += capfd.readouterr().err
        return text in said

    until(lambda: says("another program has this port open, too: each byte"), "the other one")
    board.clients = 1
    until(lambda: says("yours alone again"), "that it has left")
    assert terminal.ends()


def test_the_end_of_the_input_ends_it_at_a_board_that_never_falls_silent(
    board: Board, capfd: pytest.CaptureFixture[str]
) -> None:
    keyboard, typed = os.pipe()
    read, out = os.pipe()
    os.write(typed, b"p")
    os.close(typed)
    ends = {"keyboard": keyboard, "out": out}
    keys, view = KeyReader(b"\n", {}), PlainView()
    session = MonitorSession("m1", keys, view, is_typed=False, waits=False, most_s=0.3, **ends)
    thread = threading.Thread(target=session.run, args=(board.look(),), daemon=True)
    thread.start()
    assert got(board.fd, 1) == b"p"

    def has_ended() -> bool:
        os.write(board.fd, b"on\r\n")
        return not thread.is_alive()

    until(has_ended, "its end")
    assert got(read, 4) == b"on\r\n"
    assert "m1 says more; --wait listens on" in capfd.readouterr().err


def test_a_log_has_all_that_came(board: Board, tmp_path: Path) -> None:
    log = ReceivedLog(tmp_path / "log")
    terminal = Terminal(board, log=log, view=HexView())
    os.write(board.fd, bytes(range(256)))
    until(lambda: (tmp_path / "log").read_bytes() == bytes(range(256)), "the log")
    assert terminal.ends()
    log.close()


def test_a_full_disk_ends_the_log_alone(board: Board) -> None:
    log = ReceivedLog(Path("/dev/full"))
    terminal = Terminal(board, log=log)
    for piece in (b"one", b"two"):
        os.write(board.fd, piece)
        until(partial(terminal.shows, piece), "what came")
    assert log.failure == "/dev/full: No space left on device"
    assert terminal.ends()
