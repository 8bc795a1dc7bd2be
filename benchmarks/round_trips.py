"""A command to a board and its answer back, through a pseudo-terminal and over TCP, against bare echoes.

The clients are pyserial, as users have it, and a socket. The echoes: a callback that reads and writes at a
pseudo-terminal, and asyncio's TCP server with its streams, as in Python's documentation.

`r` is answered at once and touches no state of the axis; the number that follows sets the set-point, so that
the answer may have to wait for the core to leave the axis.

Tenth percentiles are compared: the way itself, without what other load adds. Medians and 99th percentiles
are in the results.
"""

import json
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial

import serial
from _processes import Daemon, daemon
from _report import check_work, is_quick, report

from hil.net.control_client import ask

PTY_LIMIT, TCP_LIMIT = 1.8, 1.15
WAKE_US = 1000.0
BLOCKS, TRIPS = 5 if is_quick() else 20, 200
STARTED_S = 4.5
FAST, STATE = (b"r", 17), (b"0\n", 6)
"""Commands, and the lengths of their answers."""
SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
CONFIG = json.dumps({"bench": "bench", "devices": {"m1": SERVO, "m2": SERVO | {"port": "tcp"}}})
PTY_ECHO = """
import asyncio, os, pty, tty
master, slave = pty.openpty()
tty.setraw(slave)
print(os.ttyname(slave), flush=True)
async def main():
    asyncio.get_running_loop().add_reader(master, lambda: os.write(master, os.read(master, 4096)))
    await asyncio.sleep(3600)
asyncio.run(main())
"""
TCP_ECHO = """
import asyncio
async def echo(reader, writer):
    while data := await reader.read(4096):
        writer.write(data)
        await writer.drain()
async def main():
    server = await asyncio.start_server(echo, "127.0.0.1", 0)
    print(server.sockets[0].getsockname()[1], flush=True)
    await server.serve_forever()
asyncio.run(main())
"""
Trip = Callable[[bytes, int], float]
"""Has a command answered with so many bytes; returns the time in microseconds."""


@contextmanager
def echo(program: str) -> Iterator[str]:
    """Run an echo for the block; answers its first line: where it listens."""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout
    try:
        yield process.stdout.readline().strip()
    finally:
        process.kill()
        process.wait()


def trip_us(port: serial.Serial, command: bytes, length: int) -> float:
    began = time.perf_counter_ns()
    port.write(command)
    answer = port.read(length)
    taken = (time.perf_counter_ns() - began) / 1000
    check_work("bytes answered", len(answer), length)
    return taken


def opened(path: str) -> serial.Serial:
    return serial.Serial(path, 115200, timeout=5)


def tcp_trip_us(connection: socket.socket, command: bytes, length: int) -> float:
    began = time.perf_counter_ns()
    connection.sendall(command)
    answer = connection.recv(length)
    taken = (time.perf_counter_ns() - began) / 1000
    check_work("bytes answered", len(answer), length)
    return taken


def connected(port: str) -> socket.socket:
    connection = socket.create_connection(("127.0.0.1", int(port)), 5)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection


def tcp_number(running: Daemon) -> str:
    """Number of the TCP port at the second board."""
    (path,) = running.folder.glob("run/*/control.sock")
    listed = json.dumps(ask(path, "list"))
    return listed.partition('"socket://127.0.0.1:')[2].partition('"')[0]


def compare(name: str, bare: Trip, board: Trip, limit: float) -> None:
    """Have blocks of trips in turn, and report them."""
    echoes, fast, state = [], [], []
    for _ in range(BLOCKS):
        echoes += [bare(b"r", 1) for _ in range(TRIPS)]
        for _ in range(TRIPS // 2):
            fast.append(board(*FAST))
            state.append(board(*STATE))
    reference = statistics.quantiles(echoes, n=10)[0]
    for of, trips, most in (
        (name, fast, limit),
        (f"{name}_axis", state, limit + WAKE_US / reference),
    ):
        others = {
            "reference": "one byte through a bare asyncio echo; the same client at both; tenth percentiles",
            "median_us": statistics.median(trips),
            "reference_median_us": statistics.median(echoes),
            "p99_us": statistics.quantiles(trips, n=100)[98],
            "reference_p99_us": statistics.quantiles(echoes, n=100)[98],
        }
        report(of, statistics.quantiles(trips, n=10)[0], "us", reference, most, others)


def main() -> None:
    with ExitStack() as stack:
        terminal, number = (stack.enter_context(echo(program)) for program in (PTY_ECHO, TCP_ECHO))
        running = stack.enter_context(daemon(CONFIG))
        bare, board = opened(terminal), opened(running.port("m1"))
        time.sleep(STARTED_S)
        board.reset_input_buffer()
        compare("pty_round_trip", partial(trip_us, bare), partial(trip_us, board), PTY_LIMIT)
        echoing, socketed = connected(number), connected(tcp_number(running))
        compare("tcp_round_trip", partial(tcp_trip_us, echoing), partial(tcp_trip_us, socketed), TCP_LIMIT)


if __name__ == "__main__":
    main()
