"""Terminals after a client: whatever it leaves behind, the next one finds a port that works."""

import asyncio
import fcntl
import os
import struct
import termios
from collections.abc import Callable
from pathlib import Path

import pytest

from hil.testing.ports import RecordingHost, Scenario, open_fds, read_exactly, run_port, until
from hil.vocab.ports import Port, PortContext
from virtual_ports.pty.port import Options, make

TIOCVHANGUP = 0x5437
TIOCSLCKTRMIOS = 0x5457
N_SLIP, N_NULL = 1, 27
needs_root = pytest.mark.skipif(os.getuid() != 0, reason="only root can do this to a terminal")


def client(port: Port) -> int:
    return os.open(port.address, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)


def run(directory: Path, scenario: Scenario) -> None:
    run_port(make(Options(), PortContext("b", "m1", directory)), scenario)


async def works(port: Port, board: RecordingHost) -> None:
    """A client that opens the name now is heard and hears, bytes as they are."""
    board.got.clear()
    fd = client(port)
    os.write(fd, b"p\r\n\x03\xff")
    await until(lambda: board.got == b"p\r\n\x03\xff")
    port.write(b"a\r\nb\x13")
    assert await read_exactly(fd, 5) == b"a\r\nb\x13"
    os.close(fd)
    await until(lambda: port.stats().clients == 0)
    assert board.failures == []


def line_discipline(number: int) -> Callable[[int], object]:
    return lambda fd: fcntl.ioctl(fd, termios.TIOCSETD, struct.pack("i", number))


def odd_settings(fd: int) -> None:
    settings = termios.tcgetattr(fd)
    settings[0] = settings[1] = settings[3] = 0o7777 & ~termios.TOSTOP
    settings[6][termios.VMIN], settings[6][termios.VTIME] = 200, 50
    termios.tcsetattr(fd, termios.TCSANOW, settings)


def stopped_by_xoff(fd: int) -> None:
    settings = termios.tcgetattr(fd)
    settings[0] |= termios.IXON
    settings[3] |= termios.ICANON
    termios.tcsetattr(fd, termios.TCSANOW, settings)
    termios.tcflow(fd, termios.TCOOFF)


LEFT: dict[str, Callable[[int], object]] = {
    "stopped": lambda fd: termios.tcflow(fd, termios.TCOOFF),
    "stopped, and XON/XOFF": stopped_by_xoff,
    "odd settings": odd_settings,
    "exclusive": lambda fd: fcntl.ioctl(fd, termios.TIOCEXCL),
    "no line discipline": line_discipline(N_NULL),
    "SLIP": line_discipline(N_SLIP),
}


@pytest.mark.parametrize("leave", LEFT.values(), ids=LEFT)
def test_the_next_client_finds_a_port_that_works(tmp_path: Path, leave: Callable[[int], object]) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        for _ in range(3):
            fd = client(port)
            await until(lambda: port.stats().clients == 1)
            try:
                leave(fd)
            except OSError as error:
                pytest.skip(f"this kernel: {error.strerror}")
            finally:
                os.close(fd)
            await until(lambda: port.stats().clients == 0)
            await works(port, board)

    run(tmp_path, scenario)


def test_one_that_is_there_before_the_port_has_noticed_is_not_held_up(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        fd = client(port)
        await until(lambda: port.stats().clients == 1)
        termios.tcflow(fd, termios.TCOOFF)
        os.close(fd)
        fd = client(port)
        await until(lambda: port.stats().connects == 2)
        os.write(fd, b"p")
        await until(lambda: board.got == b"p")
        os.close(fd)

    run(tmp_path, scenario)


@pytest.mark.parametrize("leave", [LEFT["stopped"], stopped_by_xoff], ids=["stopped", "and XON/XOFF"])
def test_a_stop_that_one_client_has_left_does_not_hold_up_the_others(
    tmp_path: Path, leave: Callable[[int], object]
) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        stays = client(port)
        leaves = client(port)
        await until(lambda: port.stats().clients == 2)
        leave(leaves)
        os.close(leaves)
        await until(lambda: port.stats().clients == 1)
        comes = client(port)
        for fd in (stays, comes):
            board.got.clear()
            os.write(fd, b"p")
            await until(lambda: board.got == b"p")
            os.close(fd)

    run(tmp_path, scenario)


@pytest.mark.long
@needs_root
@pytest.mark.parametrize(
    "kill",
    [
        lambda fd: fcntl.ioctl(fd, TIOCVHANGUP),
        lambda fd: fcntl.ioctl(fd, TIOCSLCKTRMIOS, b"\xff" * 60),
    ],
    ids=["hung up", "locked settings"],
)
def test_a_terminal_that_root_has_made_useless_is_replaced(
    tmp_path: Path, kill: Callable[[int], object]
) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        before = None
        for count in range(5):
            fd = client(port)
            kill(fd)
            os.close(fd)
            pts = Path(port.address).readlink()
            await until(lambda: Path(port.address).readlink() != pts)  # noqa: B023
            await works(port, board)
            assert port.stats().connects == 2 * count + 2
            before = before or len(open_fds())
            assert len(open_fds()) == before

    run(tmp_path, scenario)


@needs_root
def test_a_hang_up_from_outside_lets_the_others_go_and_new_ones_in(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        fds = [client(port) for _ in range(3)]
        await until(lambda: port.stats().clients == 3)
        pts = Path(port.address).readlink()
        fcntl.ioctl(fds[0], TIOCVHANGUP)
        os.close(fds[0])
        await until(lambda: Path(port.address).readlink() != pts)
        assert (port.stats().clients, port.stats().connects) == (0, 3)
        await works(port, board)
        for fd in fds[1:]:
            assert os.read(fd, 1) == b""
            os.close(fd)
        await asyncio.sleep(0)
        await works(port, board)
        await until(lambda: len(board.left) == 3)

    run(tmp_path, scenario)
