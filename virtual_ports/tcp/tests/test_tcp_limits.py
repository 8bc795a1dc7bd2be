"""No more clients than fit: the others are turned away, said once, and nobody else notices."""

import asyncio
import logging
import resource
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from hil.net.tcp_port import KEEP_ALIVE, RESERVED_FDS
from hil.testing.ports import RecordingHost, Scenario, open_fds, run_port, until
from hil.vocab.ports import Port, PortContext
from virtual_ports.tcp.port import Options, make


def run(scenario: Scenario, max_clients: int = 32) -> None:
    run_port(make(Options(max_clients=max_clients), PortContext("b", "m1", Path("/nowhere"))), scenario)


def connect(port: Port) -> socket.socket:
    host, number = port.address.removeprefix("socket://").split(":")
    connection = socket.create_connection((host, int(number)))
    connection.setblocking(False)
    return connection


async def read(connection: socket.socket) -> bytes:
    return await asyncio.wait_for(asyncio.get_running_loop().sock_recv(connection, 100), 20)


@contextmanager
def files(most: int) -> Iterator[None]:
    """Limit file descriptors to numbers below this one."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def next_fd() -> int:
    with socket.socket() as probe:
        return probe.fileno()


def test_a_client_too_many_is_turned_away(caplog: pytest.LogCaptureFixture) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        first, second = connect(port), connect(port)
        await until(lambda: port.stats().clients == 2)
        for _ in range(40):
            with connect(port) as late:
                assert await read(late) == b""
        first.send(b"1")
        second.send(b"2")
        await until(lambda: len(board.got) == 2)
        port.write(b"all")
        assert (await read(first), await read(second)) == (b"all", b"all")
        assert (port.stats().clients, port.stats().turned_away) == (2, 40)
        first.close()
        await until(lambda: port.stats().clients == 1)
        with connect(port) as again:
            await until(lambda: port.stats().clients == 2)
            port.write(b"x")
            assert await read(again) == b"x"
        second.close()

    with caplog.at_level(logging.INFO):
        run(scenario, max_clients=2)
    (said,) = caplog.messages
    assert said.startswith(
        "tcp port of m1: 2 clients are connected, another one was turned away; max_clients"
    )


def test_the_last_files_are_for_others(caplog: pytest.LogCaptureFixture) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        with connect(port) as early:
            await until(lambda: port.stats().clients == 1)
            with files(next_fd() + RESERVED_FDS), connect(port) as late, connect(port) as later:
                assert (await read(late), await read(later)) == (b"", b"")
                early.send(b"m")
                await until(lambda: board.got == b"m")
            with connect(port):
                await until(lambda: port.stats().clients == 2)

    run(scenario)
    (said,) = caplog.messages
    assert "files are open at most, a client was turned away; raise the limit" in said


@pytest.mark.long
def test_without_files_clients_wait(caplog: pytest.LogCaptureFixture) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        with connect(port) as early, connect(port) as late:
            await until(lambda: port.stats().clients == 2)
            waiting = [socket.socket() for _ in range(20)]
            with files(next_fd()):
                for client in waiting:
                    client.connect(late.getpeername())
                await until(lambda: bool(caplog.messages))
                early.send(b"m")
                await until(lambda: board.got == b"m")
                await until(lambda: port.stats().turned_away == 3)  # a second apart
            ended_s = time.monotonic()
            await until(lambda: port.stats().clients == 22)
            assert time.monotonic() - ended_s < 10
            for client in waiting:
                client.close()

    fds = open_fds()
    run(scenario)
    assert open_fds() == fds
    (said,) = caplog.messages
    assert said == "tcp port of m1: new clients have to wait: Too many open files"


def test_a_vanished_client_is_looked_for() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        with connect(port):
            await until(lambda: port.stats().clients == 1)
            (client,) = port._clients.values()  # type: ignore[attr-defined]
            options = {
                name: client.connection.getsockopt(socket.IPPROTO_TCP, getattr(socket, name))
                for name in KEEP_ALIVE
            }
            assert options == KEEP_ALIVE
            assert not client.has_vanished()

    run(scenario)
