"""Modbus door: reads over TCP beside pymodbus's server with static data, and answers of a serial line.

1. One pymodbus client that reads ten registers, in turns: wanted are 0.8 of the bare server's rate, and a p99
   of at most 1.25 of its.
2. 32 clients at once, each with one request under way. Wanted: the slowest gets at least half of what the
   fastest gets.
3. A line of 115200 baud on a pseudo-terminal: from the end of the silence (t3.5) behind a request to the
   first byte of the answer. Wanted: p99 at most 1 ms. In turns with it a bare program that does nothing but
   wait for the silence and send as many bytes: what the kernel's pseudo-terminals and other work take.
"""

import asyncio
import json
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import serial
from _processes import daemon
from _report import is_quick, report

from bridges.modbus.protocol import mbap
from bridges.modbus.protocol.client_side import encode as encode_request
from bridges.modbus.protocol.client_side import read
from bridges.modbus.protocol.frame import encode
from bridges.modbus.protocol.pdu import Table
from hil.wire.serial_line import silence_ns

RUNS = 5 if is_quick() else 11
READS = 1_000 if is_quick() else 5_000
CLIENTS = 32
CLIENTS_S = 2 if is_quick() else 10
TRIPS = 1_000 if is_quick() else 5_000
BAUD = 115200
LINE_LIMIT_US = 1000.0
UP_S = 4.5
REQUEST = encode_request(read(Table.INPUT_REGISTERS, 0, 10))
ANSWER_BYTES = 2 + 20
BARE = """
import asyncio, sys
from pymodbus.server import StartAsyncTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice
data = SimData(0, count=100, values=7, datatype=DataType.REGISTERS)
asyncio.run(StartAsyncTcpServer(SimDevice(1, [data]), address=("127.0.0.1", int(sys.argv[1]))))
"""


BARE_LINE = """
import asyncio, os, pty, sys, tty
from hil.net.silence_timer import SilenceTimer
master, slave = pty.openpty()
tty.setraw(slave)
print(os.ttyname(slave), flush=True)
async def main():
    timer = SilenceTimer(lambda: os.write(master, bytes(int(sys.argv[2]))))
    def come():
        os.read(master, 4096)
        timer.start(int(sys.argv[1]))
    asyncio.get_running_loop().add_reader(master, come)
    await asyncio.sleep(3600)
asyncio.run(main())
"""


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return int(taken.getsockname()[1])


@contextmanager
def bare_server() -> Iterator[int]:
    """Run pymodbus's server; its port."""
    port = free_port()
    command = [sys.executable, "-c", BARE, str(port)]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)  # it logs each client that leaves
    try:
        deadline_s = time.monotonic() + 20
        while True:
            try:
                socket.create_connection(("127.0.0.1", port)).close()
                break
            except ConnectionRefusedError:
                if process.poll() is not None or time.monotonic() > deadline_s:
                    raise RuntimeError("pymodbus's server did not start") from None
                time.sleep(0.02)
        yield port
    finally:
        process.kill()
        process.wait()


def p99(values: list[float]) -> float:
    return statistics.quantiles(values, n=100)[98]


def one_client(ports: tuple[int, int]) -> None:
    """Read in turns at the door and at the bare server; medians of the runs' rates and p99s."""
    from pymodbus.client import ModbusTcpClient

    rates: list[list[float]] = [[], []]
    tails_us: list[list[float]] = [[], []]
    clients = [ModbusTcpClient("127.0.0.1", port=port) for port in ports]
    for client in clients:
        client.connect()
        for _ in range(100):
            client.read_input_registers(0, count=10, device_id=1)
    for run in range(RUNS):
        for which in (0, 1) if run % 2 else (1, 0):
            trips_us = []
            began = time.perf_counter()
            for _ in range(READS):
                sent = time.perf_counter()
                answer = clients[which].read_input_registers(0, count=10, device_id=1)
                trips_us.append((time.perf_counter() - sent) * 1e6)
                if answer.isError() or len(answer.registers) != 10:
                    raise RuntimeError(f"answered with {answer}")
            rates[which].append(READS / (time.perf_counter() - began))
            tails_us[which].append(p99(trips_us))
    for client in clients:
        client.close()
    about: dict[str, object] = {"reference": "a bare server of pymodbus with static data; pymodbus's client"}
    ours, bare = (statistics.median(each) for each in rates)
    extra = about | {"rates": rates[0], "reference_rates": rates[1]}
    report("modbus_door_read", 1e6 / ours, "us", 1e6 / bare, 1 / 0.8, extra)
    print(f"  {ours:,.0f} a second, reference {bare:,.0f}, {ours / bare:.2f} of it (wanted at least 0.8)")
    extra = about | {"p99s_us": tails_us[0], "reference_p99s_us": tails_us[1]}
    tail_us, bare_tail_us = (statistics.median(each) for each in tails_us)
    report("modbus_door_read_p99", tail_us, "us", bare_tail_us, 1.25, extra)


class Client(asyncio.Protocol):
    """Client that asks again as soon as it has the answer. 32 of pymodbus's would be slower than the door."""

    def __init__(self) -> None:
        self.answers = 0
        self._splitter = mbap.MbapSplitter()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport

    def ask(self) -> None:
        self._transport.write(mbap.encode(self.answers & 0xFFFF, 1, REQUEST))

    def data_received(self, data: bytes) -> None:
        for _ in self._splitter.feed(data):
            self.answers += 1
            self.ask()

    def leave(self) -> None:
        self._transport.abort()


async def many_clients(port: int) -> list[int]:
    """Answers that each of the clients gets."""
    loop = asyncio.get_running_loop()
    clients = [(await loop.create_connection(Client, "127.0.0.1", port))[1] for _ in range(CLIENTS)]
    for client in clients:
        client.ask()
    await asyncio.sleep(CLIENTS_S)
    counts = [client.answers for client in clients]
    for client in clients:
        client.leave()
    return counts


def at_once(ports: tuple[int, int]) -> None:
    ours, bare = (asyncio.run(many_clients(port)) for port in ports)
    extra: dict[str, object] = {
        "reference": "the slowest of the same clients",
        "answers": ours,
        "bare_answers": bare,
    }
    report("modbus_door_32_clients", max(ours), "answers", min(ours), 2, extra)
    rates = [f"{sum(each) / CLIENTS_S:,.0f} a second" for each in (ours, bare)]
    print(f"  {rates[0]} in all, slowest {min(ours) / max(ours):.2f} of the fastest (wanted at least 0.5)")
    print(f"  bare server: {rates[1]}, slowest {min(bare) / max(bare):.2f}")


@contextmanager
def bare_line() -> Iterator[str]:
    """Run the bare program; the path of its pseudo-terminal."""
    command = [sys.executable, "-c", BARE_LINE, str(silence_ns(BAUD)), str(ANSWER_BYTES + 3)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout
    try:
        yield process.stdout.readline().strip()
    finally:
        process.kill()
        process.wait()


def late_us(port: serial.Serial, request: bytes) -> float:
    """Time from the end of the silence to the first byte of the answer."""
    began = time.perf_counter()
    port.write(request)
    first = port.read(1)
    took_us = (time.perf_counter() - began) * 1e6
    if len(first + port.read(ANSWER_BYTES + 2)) != ANSWER_BYTES + 3:
        raise RuntimeError("the line did not answer")
    return took_us - silence_ns(BAUD) / 1000


def line(paths: tuple[str, str]) -> None:
    """Requests on a serial line and on the bare one, with pauses of changing lengths between them."""
    request = encode(1, REQUEST[0], REQUEST[1:])
    ports = [serial.Serial(path, BAUD, timeout=5) for path in paths]
    times_us: tuple[list[float], list[float]] = ([], [])
    time.sleep(0.1)
    for trip in range(TRIPS):
        for which in (0, 1) if trip % 2 else (1, 0):
            times_us[which].append(late_us(ports[which], request))
            time.sleep(trip % 7 * 0.0003)
    for port in ports:
        port.close()
    (ours, bare), (median, bare_median) = map(p99, times_us), map(statistics.median, times_us)
    extra: dict[str, object] = {
        "reference": "the limit; both from the end of t3.5",
        "median_us": median,
        "bare_p99_us": bare,
        "bare_median_us": bare_median,
    }
    report("modbus_door_line_p99", ours, "us", LINE_LIMIT_US, 1, extra)
    print(f"  median {median:.0f} us, earliest {min(times_us[0]):.0f} us after t3.5")
    print(f"  bare: p99 {bare:.0f} us, median {bare_median:.0f} us, earliest {min(times_us[1]):.0f} us")


def main() -> None:
    port = free_port()
    config = {
        "bench": "bench",
        "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}},
        "bridges": {"modbus": {"listen": f"127.0.0.1:{port}", "rtu": [{"path": "plc", "baud": BAUD}]}},
    }
    with bare_server() as bare, daemon(json.dumps(config)) as running:
        time.sleep(UP_S)
        one_client((port, bare))
        at_once((port, bare))
        with bare_line() as reference:
            line((running.port("plc"), reference))


if __name__ == "__main__":
    main()
