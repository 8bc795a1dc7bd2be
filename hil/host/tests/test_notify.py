"""Messages to the service manager: the test is the manager, with a socket of its own."""

import logging
import os
import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from hil.host.journal import JournalFormatter, is_journal, prefixed
from hil.host.notify import Heartbeat, Notifier, Throttle

PID = 4711


@pytest.fixture(params=["path", "abstract"])
def manager(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[str, socket.socket]]:
    """The address as the environment has it, and the socket that hears."""
    name = str(tmp_path / "notify") if request.param == "path" else f"@hil-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
        heard.bind(name.replace("@", "\0", 1) if name.startswith("@") else name)
        heard.settimeout(5)
        yield name, heard


def test_each_message(manager: tuple[str, socket.socket]) -> None:
    address, heard = manager
    notifier = Notifier({"NOTIFY_SOCKET": address}, PID)
    assert notifier
    said = []
    notifier.ready("8 devices\nand more")
    notifier.reloading(12_345_678)
    notifier.status("x" * 5000)
    notifier.ping()
    notifier.stopping()
    notifier.close()
    notifier.ping()
    for _ in range(5):
        said.append(heard.recv(10_000).decode())
    assert said[0] == "READY=1\nSTATUS=8 devices and more"
    assert said[1] == "RELOADING=1\nMONOTONIC_USEC=12345"
    assert said[2] == "STATUS=" + "x" * 2000
    assert said[3:] == ["WATCHDOG=1", "STOPPING=1\nSTATUS=stopping"]


@pytest.mark.parametrize("env", [{}, {"NOTIFY_SOCKET": ""}, {"NOTIFY_SOCKET": "vsock:2:1"}])
def test_without_a_socket_nothing_is_said(env: dict[str, str]) -> None:
    notifier = Notifier(env | {"WATCHDOG_USEC": "1000000"}, PID)
    assert not notifier
    assert notifier.watchdog_ns == 0
    notifier.ready("x")
    notifier.ping()


def test_a_manager_that_is_away_is_no_trouble(tmp_path: Path) -> None:
    notifier = Notifier({"NOTIFY_SOCKET": str(tmp_path / "nobody")}, PID)
    notifier.ready("x")
    notifier.ping()
    notifier.close()


def test_a_manager_that_does_not_read_holds_nothing_up(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
        heard.bind(str(tmp_path / "full"))
        notifier = Notifier({"NOTIFY_SOCKET": str(tmp_path / "full")}, PID)
        done = threading.Event()

        def flood() -> None:
            for _ in range(5000):
                notifier.ping()
            done.set()

        threading.Thread(target=flood, daemon=True).start()
        assert done.wait(30)
        notifier.close()


@pytest.mark.parametrize(
    ("env", "ns"),
    [
        ({"WATCHDOG_USEC": "2000000"}, 2_000_000_000),
        ({"WATCHDOG_USEC": "2000000", "WATCHDOG_PID": str(PID)}, 2_000_000_000),
        ({"WATCHDOG_USEC": "2000000", "WATCHDOG_PID": "1"}, 0),  # a parent's
        ({"WATCHDOG_USEC": "soon"}, 0),
        ({"WATCHDOG_USEC": "-1"}, 0),
        ({}, 0),
    ],
)
def test_whose_watchdog_it_is(env: dict[str, str], ns: int) -> None:
    notifier = Notifier(env | {"NOTIFY_SOCKET": "/run/x"}, PID)
    assert notifier.watchdog_ns == ns
    assert notifier.ping_s <= ns / 1e9 / 2
    notifier.close()


def test_no_tick_no_ping() -> None:
    heartbeat = Heartbeat()
    asked = [0, 5, 5, 5, 6, 6, 2, 2]
    assert [heartbeat.beats(ticks) for ticks in asked] == [True, True, False, False, True, False, True, False]


def test_a_status_is_said_when_it_is_new_and_once_a_second() -> None:
    throttle = Throttle(1000)
    asked = [("a", 0), ("a", 5000), ("b", 5001), ("c", 5500), ("c", 6000), ("c", 6001), ("d", 7001)]
    assert [throttle.due(text, at) for text, at in asked] == [True, False, True, False, False, True, True]


def test_priorities_for_the_journal(tmp_path: Path) -> None:
    record = logging.LogRecord("hil", logging.ERROR, "", 0, "two\nlines of %s", ("x",), None)
    assert JournalFormatter().format(record) == "<3>two\n<3>lines of x"
    levels = (logging.CRITICAL, logging.ERROR, logging.WARNING, logging.INFO, logging.DEBUG)
    assert [prefixed("", level) for level in levels] == ["<2>", "<3>", "<4>", "<6>", "<7>"]
    with (tmp_path / "log").open("w") as file:
        stat = os.fstat(file.fileno())
        assert is_journal(file, {"JOURNAL_STREAM": f"{stat.st_dev}:{stat.st_ino}"})
        assert not is_journal(file, {"JOURNAL_STREAM": f"{stat.st_dev}:{stat.st_ino + 1}"})
        assert not is_journal(file, {})
    assert not is_journal(file, {"JOURNAL_STREAM": "1:2"})  # closed


def test_a_core_that_does_not_move_for_the_watchdogs_time_has_stopped() -> None:
    heartbeat = Heartbeat()
    looks = [(heartbeat.beats(7), heartbeat.has_stopped) for _ in range(17)]
    assert looks == [(True, False)] + 14 * [(False, False)] + 2 * [(False, True)]
    assert heartbeat.beats(8)
    assert not heartbeat.has_stopped
