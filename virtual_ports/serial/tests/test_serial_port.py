"""A real serial port, played by pseudo-terminals, sockets and pyserial's own RFC 2217 client."""

import asyncio
import fcntl
import gc
import os
import socket
import struct
import threading
import time
import tty
from collections.abc import Awaitable, Callable
from contextlib import suppress
from pathlib import Path

import pytest
from pydantic import ValidationError

from hil.testing.ports import DEADLINE_S, RecordingHost, open_fds, read_exactly, until
from hil.vocab.ports import PortContext
from virtual_ports.serial import port as module
from virtual_ports.serial.open_line import QUEUE_BYTES
from virtual_ports.serial.port import Options, SerialPort


def made(url: str) -> tuple[SerialPort, RecordingHost]:
    port = SerialPort(Options(url=url, baud=38400), PortContext("b", "s2", Path("/nowhere")))
    return port, RecordingHost(port)


def run(url: str, scenario: Callable[[SerialPort, RecordingHost], Awaitable[None]]) -> None:
    async def main() -> None:
        port, host = made(url)
        await port.open(host)
        try:
            await scenario(port, host)
        finally:
            await port.close()

    before = len(open_fds())
    asyncio.run(main())
    deadline = time.monotonic() + DEADLINE_S
    while len(open_fds()) > before:  # RFC 2217's threads end a little later
        assert time.monotonic() < deadline


@pytest.fixture
def board(tmp_path: Path):
    """The board's end of a pseudo-terminal, and the path of the other."""
    master, slave = os.openpty()
    tty.setraw(slave)
    path = os.ttyname(slave)
    os.close(slave)
    yield master, path
    os.close(master)


def test_bytes_pass_both_ways(board) -> None:
    master, path = board

    async def scenario(port: SerialPort, host: RecordingHost) -> None:
        os.write(master, bytes(range(256)))
        await until(lambda: len(host.got) == 256)
        assert host.got == bytes(range(256))
        port.write(b"hello")
        assert await read_exactly(master, 5) == b"hello"
        stats = port.stats()
        assert (stats.clients, stats.connects, stats.rx_bytes, stats.tx_bytes) == (1, 1, 256, 5)
        assert port.backlog() == 0

    run(path, scenario)


def test_a_megabyte_each_way_is_whole(board) -> None:
    master, path = board
    data = os.urandom(1_000_000)

    async def scenario(port: SerialPort, host: RecordingHost) -> None:
        port.write(data)
        assert await read_exactly(master, len(data)) == data
        os.set_blocking(master, False)
        sent = 0

        def pump() -> bool:
            nonlocal sent
            with suppress(BlockingIOError):
                sent += os.write(master, data[sent : sent + 4096])
            return len(host.got) == len(data)

        await until(pump)
        assert host.got == data

    run(path, scenario)


def test_a_board_that_does_not_read_costs_what_does_not_fit(board) -> None:
    _, path = board

    async def scenario(port: SerialPort, host: RecordingHost) -> None:
        port.write(bytes(QUEUE_BYTES + 100_000))
        stats = port.stats()
        assert stats.tx_bytes + port.backlog() + stats.dropped_bytes == QUEUE_BYTES + 100_000
        assert port.backlog() == QUEUE_BYTES

    run(path, scenario)


def test_no_room_stops_the_reading(board) -> None:
    master, path = board

    async def scenario(port: SerialPort, host: RecordingHost) -> None:
        host.room_bytes = 3
        os.write(master, b"abcdef")
        await until(lambda: host.got == b"abc")
        for _ in range(20):
            await asyncio.sleep(0)
        assert host.got == b"abc"
        host.room_bytes = 100
        port.resume_reading()
        await until(lambda: host.got == b"abcdef")

    run(path, scenario)


def test_a_board_that_goes_comes_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "AGAIN_S", 0.01)
    link = tmp_path / "ttyUSB0"

    def plug() -> int:
        master, slave = os.openpty()
        tty.setraw(slave)
        link.unlink(missing_ok=True)
        link.symlink_to(os.ttyname(slave))
        os.close(slave)
        return master

    async def scenario(port: SerialPort, host: RecordingHost) -> None:
        assert port.away
        assert port.away == "No such file or directory; plug it in, or correct its path"
        port.write(b"lost")
        assert port.stats().unheard_bytes == 4
        for connects in (1, 2, 3):
            master = plug()
            await until(lambda: port.stats().clients == 1)
            assert port.stats().connects == connects
            port.write(b"hello")
            assert await read_exactly(master, 5) == b"hello"
            os.write(master, b"x" * connects)
            await until(lambda: len(host.got) == sum(range(connects + 1)))  # noqa: B023 - awaited here
            link.unlink()
            os.close(master)
            await until(lambda: port.stats().clients == 0)
        assert port.away
        assert host.failures == []

    run(str(link), scenario)


def test_a_file_is_no_serial_port(tmp_path: Path) -> None:
    async def scenario(port: SerialPort, host: RecordingHost) -> None:
        assert port.away == "this is no serial port, but a file; write a path as in /dev/ttyUSB0"

    (tmp_path / "b.yaml").touch()
    run(str(tmp_path / "b.yaml"), scenario)


def test_a_port_of_another_program_is_told_so() -> None:
    master, slave = os.openpty()
    fcntl.flock(slave, fcntl.LOCK_EX)

    async def scenario(port: SerialPort, host: RecordingHost) -> None:
        assert port.away == "in use by another program; close it there"

    run(os.ttyname(slave), scenario)
    os.close(master)
    os.close(slave)


def test_a_socket_is_a_serial_port_too() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        async def scenario(port: SerialPort, host: RecordingHost) -> None:
            peer, _ = server.accept()
            with peer:
                port.write(b"hello")
                assert peer.recv(5) == b"hello"
                peer.sendall(b"world")
                await until(lambda: host.got == b"world")
            await until(lambda: port.stats().clients == 0)

        run(f"socket://127.0.0.1:{server.getsockname()[1]}", scenario)


def test_a_socket_that_its_peer_resets_is_closed() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        async def scenario(port: SerialPort, host: RecordingHost) -> None:
            peer, _ = server.accept()
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            peer.close()  # a reset
            await until(lambda: port.stats().clients == 0)

        run(f"socket://127.0.0.1:{server.getsockname()[1]}", scenario)
    gc.collect()  # an unclosed socket would warn here


@pytest.mark.filterwarnings("ignore:set(Daemon|Name)")  # pyserial 3.5 of its threads
def test_rfc2217_passes_bytes_with_its_own_in_them() -> None:
    """Talk to the smallest server that pyserial's client talks to: it agrees to everything, and echoes."""
    iac, sb, se, will, do = 255, 250, 240, 251, 253

    def serve(listener: socket.socket) -> None:
        peer, _ = listener.accept()
        held = b""
        with peer:
            while data := peer.recv(4096):
                held += data
                while held:
                    if held[0] != iac:
                        end = held.find(bytes((iac,)))
                        end = len(held) if end < 0 else end
                        peer.sendall(held[:end])
                        held = held[end:]
                    elif len(held) < 2:
                        break
                    elif held[1] == iac:
                        peer.sendall(held[:2])
                        held = held[2:]
                    elif held[1] == sb:
                        end = held.find(bytes((iac, se)))
                        if end < 0:
                            break
                        if held[2] == 44:  # COM-PORT-OPTION: the answer has the request's number plus 100
                            peer.sendall(bytes((iac, sb, 44, held[3] + 100)) + held[4 : end + 2])
                        held = held[end + 2 :]
                    elif len(held) < 3:
                        break
                    else:
                        answer = {will: do, do: will}.get(held[1])
                        if answer:
                            peer.sendall(bytes((iac, answer, held[2])))
                        held = held[3:]

    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=serve, args=(server,))
        thread.start()

        async def scenario(port: SerialPort, host: RecordingHost) -> None:
            assert port.away is None, port.away
            port.write(bytes(range(256)))
            await until(lambda: len(host.got) == 256)
            assert host.got == bytes(range(256))
            host.room_bytes = 0
            port.write(b"held")
            await until(lambda: port.stats().tx_bytes == 260)
            host.room_bytes = 10
            port.resume_reading()
            await until(lambda: host.got.endswith(b"held"))

        run(f"rfc2217://127.0.0.1:{server.getsockname()[1]}", scenario)
        thread.join(20)
        assert not thread.is_alive()


@pytest.mark.parametrize("url", ["ttyUSB0", "", "http://x:1", "socket://x", "socket://:80", "rfc2217://x:0"])
def test_what_is_no_serial_port_is_refused(url: str) -> None:
    with pytest.raises(ValidationError, match="no serial port"):
        Options(url=url)


def test_a_port_without_rs485_says_so(board) -> None:
    _, path = board

    async def main() -> None:
        options = Options(url=path, baud=38400, rs485=True)
        port = SerialPort(options, PortContext("b", "s2", Path("/nowhere")))
        await port.open(RecordingHost(port))
        assert port.away
        assert "RS485" in port.away
        await port.close()

    asyncio.run(main())
