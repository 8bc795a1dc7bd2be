"""Clients that come and go: who is counted, what settings they see and leave, what a race can lose."""

import asyncio
import errno
import fcntl
import os
import resource
import signal
import sys
import termios
from pathlib import Path

import pytest
import serial

from hil.testing.ports import RecordingHost, Scenario, accounted, open_fds, read_exactly, run_port, until
from hil.vocab.ports import Port, PortContext
from virtual_ports.pty.clients import Clients
from virtual_ports.pty.pair import PtyPair
from virtual_ports.pty.port import Options, make

DEADLINE_S = 20.0
RACES = 200


def client(port: Port, flags: int = os.O_RDWR) -> int:
    return os.open(port.address, flags | os.O_NOCTTY | os.O_NONBLOCK)


def run(directory: Path, scenario: Scenario) -> None:
    run_port(make(Options(), PortContext("b", "m1", directory)), scenario)


def test_the_terminal_is_raw_when_its_name_appears_and_again_for_the_next_client(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        for _ in range(2):
            fd = client(port)
            iflag, oflag, _, lflag = termios.tcgetattr(fd)[:4]
            assert (iflag, oflag, lflag) == (0, 0, 0)
            cooked = termios.tcgetattr(fd)
            cooked[0], cooked[1], cooked[3] = termios.ICRNL, termios.OPOST, termios.ECHO | termios.ICANON
            termios.tcsetattr(fd, termios.TCSANOW, cooked)
            await until(lambda: port.stats().clients == 1)
            os.close(fd)
            await until(lambda: port.stats().clients == 0)

    run(tmp_path, scenario)


def test_clients_of_other_terminals_do_not_keep_a_line_from_its_rest(tmp_path: Path) -> None:
    """All ptys of a system share a directory, and one of another program may open at any moment."""

    async def main() -> None:
        pair = PtyPair(lambda error: pytest.fail(str(error)))

        def left(baud: int | None) -> None:
            for fd in os.openpty():
                os.close(fd)

        clients = Clients(pair, asyncio.get_running_loop(), lambda: None, left)
        fd = os.open(pair.pts, os.O_RDWR | os.O_NOCTTY)
        cooked = termios.tcgetattr(fd)
        cooked[3] = termios.ICANON
        termios.tcsetattr(fd, termios.TCSANOW, cooked)
        clients.notice()
        os.close(fd)
        clients.notice()
        assert (clients.count, termios.tcgetattr(pair.slave)[3]) == (0, 0)
        clients.close()
        pair.close()

    asyncio.run(main())


def test_several_clients_share_the_line(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        fds = [client(port) for _ in range(5)]
        port.write(b"")
        assert (port.stats().clients, port.stats().connects) == (5, 5)
        os.write(fds[0], b"a")
        os.write(fds[4], b"b")
        await until(lambda: board.got == b"ab")
        for left in (4, 3, 2, 1):
            os.close(fds.pop())
            port.write(b"x")
            assert port.stats().clients == left
        assert await read_exactly(fds[0], 4) == b"xxxx"  # the line was not flushed while one was there
        os.close(fds.pop())
        port.write(b"y")
        assert (port.stats().clients, port.stats().unheard_bytes) == (0, 1)

    run(tmp_path, scenario)


def test_the_baud_of_a_client_is_seen_and_forgotten(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        assert port.client_baud() is None
        for baud in (9600, 115200, 250000, 12345, 2000000):
            with serial.Serial(port.address, baud):
                await until(lambda: port.stats().clients == 1)
                assert port.client_baud() == baud
            await until(lambda: port.stats().clients == 0)
            assert port.client_baud() is None
        fd = client(port)
        await until(lambda: port.stats().clients == 1)
        assert port.client_baud() is None
        os.close(fd)

    run(tmp_path, scenario)


def test_the_host_is_told_when_the_last_client_leaves_and_at_which_baud(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        for baud in (1200, 250000):
            with serial.Serial(port.address, baud):
                await until(lambda: port.stats().clients == 1)
            await until(lambda baud=baud: board.left[-1:] == [baud])  # type: ignore[misc]
        fds = [client(port) for _ in range(3)]
        await until(lambda: port.stats().clients == 3)
        for fd in fds:
            assert len(board.left) == 2
            os.close(fd)
            await until(lambda fd=fd: port.stats().clients == 2 - fds.index(fd))  # type: ignore[misc]
        await until(lambda: board.left == [1200, 250000, None])

    run(tmp_path, scenario)


def test_the_host_may_answer_when_the_last_client_has_left(tmp_path: Path) -> None:
    class Answering(RecordingHost):
        def client_left(self, baud: int | None) -> None:
            super().client_left(baud)
            self.port.write(b"booting")

    async def main() -> None:
        port = make(Options(), PortContext("b", "m1", tmp_path))
        host = Answering(port)
        await port.open(host)
        os.close(client(port))
        port.write(b"x")  # here the port notices; the host is not called from within
        assert host.left == []
        await until(lambda: len(host.left) == 1)
        assert port.stats().unheard_bytes == len(b"xbooting")
        await port.close()

    asyncio.run(main())


def test_bytes_of_a_client_that_has_left_still_have_its_baud(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        board.room_bytes = 0
        with serial.Serial(port.address, 19200) as line:
            line.write(b"m\r")
        await until(lambda: port.stats().connects == 1 and port.stats().clients == 0)
        for _ in range(2):
            board.room_bytes = 1
            port.resume_reading()
            await until(lambda: board.room_bytes == 0)
        assert board.got == b"m\r"
        assert board.bauds == [19200, 19200]
        assert port.client_baud() is None

    run(tmp_path, scenario)


def test_8e1_can_be_opened_again_and_again(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        for number in range(1, 21):
            with serial.Serial(port.address, 19200, parity=serial.PARITY_EVEN) as line:
                await until(lambda number=number: port.stats().connects == number)  # type: ignore[misc]
                assert port.client_baud() == 19200
                line.write(b"8E1")
            await until(lambda number=number: len(board.got) == 3 * number)  # type: ignore[misc]
            await until(lambda: port.stats().clients == 0)

    run(tmp_path, scenario)


def test_exclusive_use_ends_with_the_client(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        os.chmod(port.address, 0o666)
        code = (
            "import os,sys,fcntl,termios\n"
            "if os.geteuid() == 0: os.setgid(65534); os.setuid(65534)\n"
            "try: fd = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)\n"
            "except OSError as error: sys.exit(error.errno)\n"
            "fcntl.ioctl(fd, termios.TIOCEXCL)\n"
        )
        pts = os.readlink(port.address)

        async def open_as_another_user() -> int:
            process = await asyncio.create_subprocess_exec(sys.executable, "-c", code, pts)
            return await process.wait()

        fd = client(port)
        fcntl.ioctl(fd, termios.TIOCEXCL)
        await until(lambda: port.stats().clients == 1)
        assert await open_as_another_user() == errno.EBUSY
        os.close(fd)
        await until(lambda: port.stats().clients == 0)
        for connects in (2, 3):
            assert await open_as_another_user() == 0
            await until(lambda connects=connects: port.stats().connects == connects)  # type: ignore[misc]
            await until(lambda: port.stats().clients == 0)

    run(tmp_path, scenario)


def test_there_are_no_modem_lines(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        with serial.Serial(port.address) as line, pytest.raises(OSError, match="ioctl") as refused:
            line.rts = False
        assert refused.value.errno == errno.ENOTTY

    run(tmp_path, scenario)


def test_a_client_that_comes_as_another_goes_loses_no_byte_and_no_reply(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        """No turn of the event loop between A's close, B's open and B's write: all come in at once."""
        board.answer = lambda data: b"<" + data + b">"
        a = client(port)
        for number in range(RACES):
            port.write(b"left unread by A")
            os.close(a)
            b = client(port)
            question = b"B%04d" % number
            os.write(b, question)
            await until(lambda question=question: board.got.endswith(question))  # type: ignore[misc]
            assert await read_exactly(b, 7) == b"<" + question + b">"
            a = b
        assert board.got == b"".join(b"B%04d" % number for number in range(RACES))
        assert port.stats().connects == RACES + 1
        os.close(a)

    run(tmp_path, scenario)


def test_clients_of_other_processes_that_take_turns_lose_nothing(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        board.answer = lambda data: data
        code = (
            "import os,sys,select\n"
            "a = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)\n"
            "for number in range(int(sys.argv[2])):\n"
            "    os.close(a)\n"
            "    a = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)\n"
            "    question, answer = b'B%04d' % number, b''\n"
            "    os.write(a, question)\n"
            "    while len(answer) < 5 and select.select([a], [], [], 10)[0]: answer += os.read(a, 100)\n"
            "    if answer != question: sys.exit(f'{question!r} {answer!r}')\n"
        )
        process = await asyncio.create_subprocess_exec(sys.executable, "-c", code, port.address, str(RACES))
        assert await process.wait() == 0
        await until(lambda: len(board.got) == 5 * RACES)
        assert board.got == b"".join(b"B%04d" % number for number in range(RACES))

    run(tmp_path, scenario)


@pytest.mark.long
def test_a_thousand_clients_leave_nothing_behind(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        fds = len(open_fds())
        for number in range(960):
            fd = client(port)
            os.write(fd, b"x")
            if number % 3 == 0:
                port.write(b"reply")
            os.close(fd)
        await until(lambda: port.stats().clients == 0 and len(board.got) == 960)
        assert port.stats().connects == 960
        code = (
            "import os,sys\n"
            "fd = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)\n"
            "while True: os.write(fd, b'k' * 500)\n"
        )
        for _ in range(10):
            before = len(board.got)
            killed = [
                await asyncio.create_subprocess_exec(sys.executable, "-c", code, port.address)
                for _ in range(4)
            ]
            await until(lambda before=before: len(board.got) > before + 5000)  # type: ignore[misc]
            for process in killed:
                process.send_signal(signal.SIGKILL)
            for process in killed:
                await process.wait()
            await until(lambda: port.stats().clients == 0)
        assert 970 <= port.stats().connects <= 1000
        fd = client(port)
        port.write(b"still here")
        assert await read_exactly(fd, 10) == b"still here"
        os.close(fd)
        assert len(open_fds()) <= fds + 2  # asyncio's own for its child processes

    run(tmp_path, scenario)


def test_opens_that_the_kernel_merges_are_put_right(tmp_path: Path) -> None:
    """Open and close in two processes without pause, on two processors: the kernel merges some events."""

    async def scenario(port: Port, board: RecordingHost) -> None:
        code = (
            "import os,sys\nfor _ in range(1000): os.close(os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY))\n"
        )
        for _ in range(3):
            both = [
                await asyncio.create_subprocess_exec(sys.executable, "-c", code, port.address)
                for _ in range(2)
            ]
            for process in both:
                await process.wait()
            await until(lambda: port.stats().clients == 0)
        fd = client(port)
        port.write(b"heard")
        assert port.stats().clients == 1
        await asyncio.sleep(0.1)
        assert port.stats().clients == 1
        os.close(fd)

    run(tmp_path, scenario)


def test_a_hundred_and_fifty_ports_live_in_one_process(tmp_path: Path) -> None:
    """Open more ports than the kernel gives inotify instances to a user."""

    async def main() -> None:
        before = open_fds()
        ports = [make(Options(), PortContext("b", f"m{number}", tmp_path)) for number in range(150)]
        boards = [RecordingHost(port) for port in ports]
        for port, board in zip(ports, boards, strict=True):
            board.port = port
            await port.open(board)
        fd = client(ports[77])
        os.write(fd, b"m")
        await until(lambda: boards[77].got == b"m")
        assert sum(port.stats().connects for port in ports) == 1
        for port in ports:
            await port.close()
            await port.close()
        with pytest.raises(OSError, match="Input/output"):
            os.write(fd, b"m")
        os.close(fd)
        assert os.listdir(tmp_path) == []
        assert open_fds() == before

    asyncio.run(main())


def test_a_terminal_that_is_hung_up_when_there_is_no_other_is_reported_once(tmp_path: Path) -> None:
    """Hang up as agetty does when it is started on a terminal; a new one needs file descriptors."""
    if os.geteuid() != 0:
        pytest.skip("needs CAP_SYS_ADMIN")

    async def main() -> None:
        port = make(Options(), PortContext("b", "m1", tmp_path))
        board = RecordingHost(port)
        board.port = port
        await port.open(board)
        fd = client(port)
        port.write(b"")
        fcntl.ioctl(fd, 0x5437)  # TIOCVHANGUP
        limits = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (fd, limits[1]))
        os.close(fd)
        try:
            await until(lambda: bool(board.failures))
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, limits)
        for _ in range(100):
            port.write(b"lost")
            await asyncio.sleep(0)
        assert len(board.failures) == 1
        assert "pty port of m1" in board.failures[0]
        assert "see the limits" in board.failures[0]
        assert accounted(port) == 400
        await port.close()
        assert os.listdir(tmp_path) == []

    asyncio.run(main())
