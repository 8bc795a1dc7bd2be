"""Real clients on a real pty: what they send, what they get, and what is counted."""

import asyncio
import os
import subprocess
import sys
import time
from pathlib import Path

from hil.net.traffic import QUEUE_BYTES
from hil.testing.ports import RecordingHost, Scenario, accounted, read_exactly, run_port, until
from hil.vocab.ports import Port, PortContext
from virtual_ports.pty.port import Options, make

DEADLINE_S = 20.0


def client(port: Port, flags: int = os.O_RDWR) -> int:
    return os.open(port.address, flags | os.O_NOCTTY | os.O_NONBLOCK)


def run(directory: Path, scenario: Scenario) -> None:
    run_port(make(Options(), PortContext("b", "m1", directory)), scenario)


def test_every_byte_value_passes_both_ways_unchanged(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        every = bytes(range(256)) * 4
        fd = client(port)
        os.write(fd, every)
        await until(lambda: len(board.got) == len(every))
        port.write(every)
        assert await read_exactly(fd, len(every)) == every
        assert board.got == every
        stats = port.stats()
        assert (stats.rx_bytes, stats.tx_bytes) == (len(every), len(every))
        os.close(fd)

    run(tmp_path, scenario)


def test_bytes_for_nobody_are_counted_and_not_kept(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        port.write(b"boot text")
        fd = client(port)
        port.write(b"heard")
        assert await read_exactly(fd, 5) == b"heard"
        os.close(fd)
        port.write(b"gone")
        assert port.stats().unheard_bytes == len(b"boot text" + b"gone")
        assert port.stats().tx_bytes == 5

    run(tmp_path, scenario)


def test_what_the_last_client_left_unread_is_not_for_the_next(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        first = client(port)
        for _ in range(20):
            port.write(bytes(1000))  # fills the terminal, its buffers in the kernel, and the port's queue
        os.close(first)
        await until(lambda: port.stats().clients == 0)
        second = client(port)
        port.write(b"new")
        assert await read_exactly(second, 3) == b"new"
        assert accounted(port) == 20_003
        os.close(second)

    run(tmp_path, scenario)


def test_open_write_close_at_once_loses_nothing(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        shell = await asyncio.create_subprocess_shell(f"echo m > {port.address}; printf n > {port.address}")
        await shell.wait()
        for number in range(200):
            fd = client(port, os.O_WRONLY)
            os.write(fd, b"%03d," % number)
            os.close(fd)
        await until(lambda: len(board.got) == 3 + 800)
        assert board.got == b"m\nn" + b"".join(b"%03d," % number for number in range(200))

    run(tmp_path, scenario)


def test_an_idle_port_without_clients_uses_no_processor_time(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        os.close(client(port))
        await until(lambda: port.stats().connects == 1 and port.stats().clients == 0)
        before = time.process_time()
        await asyncio.sleep(0.5)
        assert time.process_time() - before < 0.1

    run(tmp_path, scenario)


def test_at_room_0_the_client_is_held_up_and_nothing_is_lost(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        board.room_bytes = 10
        fd = client(port)
        sent = 0
        flood = bytes(range(256)) * 4096

        def stuck() -> bool:
            nonlocal sent
            try:
                sent += os.write(fd, flood[sent : sent + 4096])
            except BlockingIOError:
                return True
            return False

        await until(stuck)
        await until(lambda: len(board.got) == 10)
        while not stuck():
            await asyncio.sleep(0)
        assert len(board.got) == 10
        # It leaves; what it wrote stays, however often the port is opened and closed meanwhile.
        os.close(fd)
        await until(lambda: port.stats().clients == 0)
        os.close(client(port))
        await asyncio.sleep(0.1)  # longer than the check of the count takes to come
        while len(board.got) < sent:
            board.room_bytes = 777
            port.resume_reading()
            await until(lambda: board.room_bytes == 0 or len(board.got) == sent)
        assert board.got == flood[:sent]
        assert port.stats().rx_bytes == sent

    run(tmp_path, scenario)


def test_a_client_that_never_reads_costs_only_its_own_bytes(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        fd = client(port)
        total = 0
        for _ in range(300):
            port.write(bytes(20_009))
            total += 20_009
            await asyncio.sleep(0)
        stats = port.stats()
        waiting = total - accounted(port)
        assert waiting == port.backlog() == QUEUE_BYTES
        assert stats.dropped_bytes == total - stats.tx_bytes - waiting > 0
        before = time.process_time()
        await asyncio.sleep(0.3)
        assert time.process_time() - before < 0.1
        os.write(fd, b"m")
        await until(lambda: board.got == b"m")
        assert len(await read_exactly(fd, stats.tx_bytes + waiting)) == stats.tx_bytes + waiting
        assert port.stats().tx_bytes == stats.tx_bytes + waiting
        assert accounted(port) == total
        await until(lambda: board.drains == 1)
        assert port.backlog() == 0
        for _ in range(300):
            port.write(bytes(20_009))
        os.close(fd)
        await until(lambda: port.stats().clients == 0)
        assert accounted(port) == 2 * total
        await until(lambda: board.drains == 2)  # so that a device held up goes on after its client has left

    run(tmp_path, scenario)


def test_a_binary_flood_both_ways_arrives_whole(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        flood = os.urandom(1 << 20)
        board.answer = lambda data: data
        code = (
            "import os,sys,select\n"
            "fd = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)\n"
            "out, back, sent = sys.stdin.buffer.read(), b'', 0\n"
            "while len(back) < len(out):\n"
            "    ahead = sent - len(back) > 30000\n"
            "    r, w, _ = select.select([fd], [fd] if sent < len(out) and not ahead else [], [])\n"
            "    if r: back += os.read(fd, 65536)\n"
            "    if w: sent += os.write(fd, out[sent:sent + 4096])\n"
            "sys.stdout.buffer.write(back)\n"
        )
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-c", code, port.address, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        back, _ = await asyncio.wait_for(process.communicate(flood), DEADLINE_S)
        assert board.got == flood
        assert back == flood
        assert port.stats().dropped_bytes == 0

    run(tmp_path, scenario)


def test_the_first_client_opens_the_line_before_its_bytes_come(tmp_path: Path) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        first = client(port)
        os.write(first, b"abc")
        await until(lambda: len(board.got) == 3)
        second = client(port)
        os.write(second, b"d")
        await until(lambda: len(board.got) == 4)
        assert board.openings == [0]
        os.close(first)
        os.close(second)
        await until(lambda: port.stats().clients == 0)
        third = client(port)
        await until(lambda: board.openings == [0, 4])
        os.close(third)

    run(tmp_path, scenario)
