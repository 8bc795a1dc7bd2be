"""Serial ports and runs of a bench with 32 Modbus clients, beside the same bench without.

Two daemons with the same configuration on one computer, asked in turns: round trips at a board's
pseudo-terminal (pyserial; `r` and its answer), and a short run of two axes, from its submission until it is
told as done. The clients read ten registers each: every 50 ms as a control room does, then as fast as they
are answered. Medians; wanted is at most 1.1 of the bench without.
"""

import asyncio
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import serial
from _processes import Daemon, daemon
from _report import check_work, is_quick, report
from modbus_door import CLIENTS, Client, free_port
from round_trips import opened, trip_us

from hil.net.control_client import ask

LIMIT = 1.1
TURNS, TRIPS = (10, 100) if is_quick() else (40, 200)
RUNS = 3 if is_quick() else 8
POLL_S = 0.05
UP_S = 4.5
RUN = """
run: beside
axes: {m1: {velocity_rpm: 120}, m2: {velocity_rpm: 120}}
steps: [{line: {m1: 30, m2: 15}}, {line: {m1: 0, m2: 0}}]
"""
KINDS = {"polling": POLL_S, "flat_out": 0.0}


class Poller(Client):
    """Client that asks at intervals, or as soon as it has the answer."""

    def __init__(self, every_s: float) -> None:
        super().__init__()
        self._every_s = every_s

    def ask(self) -> None:
        if self._every_s and self.answers:
            asyncio.get_running_loop().call_later(self._every_s, super().ask)
        else:
            super().ask()


async def clients(port: int, every_s: float) -> None:
    """Ask forever. Prints every second how many answers there were."""
    loop, asking = asyncio.get_running_loop(), []
    for _ in range(CLIENTS):
        asking.append((await loop.create_connection(lambda: Poller(every_s), "127.0.0.1", port))[1])
        asking[-1].ask()
        await asyncio.sleep(every_s / CLIENTS)  # one after the other
    seen = 0
    while True:
        await asyncio.sleep(1)
        now = sum(each.answers for each in asking)
        print(now - seen, flush=True)
        seen = now


@contextmanager
def busy(port: int, every_s: float) -> Iterator[list[int]]:
    """Run the clients for the block. Afterwards the answers of each second are in the list."""
    rates: list[int] = []
    command = [sys.executable, __file__, "--clients", str(port), str(every_s)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout
    try:
        process.stdout.readline()
        yield rates
    finally:
        process.terminate()
        rates += [int(line) for line in process.stdout.read().split()]
        process.wait()


def control(of: Daemon) -> Path:
    return of.folder / "run" / "bench" / "control.sock"


def run_s(of: Daemon) -> float:
    """Time of a run, from its submission until it is told as done."""
    began = time.perf_counter()
    name = ask(control(of), "run", text=RUN, fresh=True)["run"]
    while (told := ask(control(of), "runs", name=name)[0])["state"] in ("queued", "running"):
        time.sleep(0.002)
    if told["state"] != "done":
        raise RuntimeError(f"the run ended as {told}")
    return time.perf_counter() - began


def measure(kind: str, with_clients: Daemon, without: Daemon, port: int) -> None:
    both = with_clients, without
    ports: list[serial.Serial] = [opened(each.port("m3")) for each in both]
    trips: tuple[list[float], list[float]] = ([], [])
    runs: tuple[list[float], list[float]] = ([], [])
    for each in ports:
        each.reset_input_buffer()
    with busy(port, KINDS[kind]) as rates:
        for turn in range(TURNS):
            for which in (0, 1) if turn % 2 else (1, 0):
                for _ in range(TRIPS):
                    trips[which].append(trip_us(ports[which], b"r", 17))
                    trip_us(ports[which], b"0\n", 6)  # it asks for an angle
        for turn in range(RUNS):
            for which in (0, 1) if turn % 2 else (1, 0):
                runs[which].append(run_s(both[which]))
    for each in ports:
        each.close()
    extra: dict[str, object] = {"reference": "the same bench without clients, at the same time"}
    p99s = [statistics.quantiles(each, n=100)[98] for each in trips]
    medians = [statistics.median(each) for each in trips]
    extra |= {"p99_us": p99s[0], "reference_p99_us": p99s[1], "requests_per_s": rates}
    report(f"modbus_beside_{kind}_pty", medians[0], "us", medians[1], LIMIT, extra)
    rate = statistics.median(rates) if rates else 0
    if KINDS[kind]:
        check_work("requests a second", rate, CLIENTS / KINDS[kind], 0.2)
    print(f"  {rate:,.0f} requests a second; p99 {p99s[0]:.0f} and {p99s[1]:.0f} us")
    extra = {"reference": extra["reference"], "runs_s": runs[0], "reference_runs_s": runs[1]}
    medians = [statistics.median(each) for each in runs]
    report(f"modbus_beside_{kind}_run", medians[0], "s", medians[1], LIMIT, extra)


def main() -> None:
    if sys.argv[1:2] == ["--clients"]:
        asyncio.run(clients(int(sys.argv[2]), float(sys.argv[3])))
    board = {"profile": "mechaduino", "flash": {"table": "identity"}}
    numbers = [free_port(), free_port()]
    texts = [
        json.dumps(
            {
                "bench": "bench",
                "devices": {"m1": board, "m2": board, "m3": board},
                "bridges": {"modbus": {"listen": f"127.0.0.1:{number}"}},
            }
        )
        for number in numbers
    ]
    with daemon(texts[0]) as with_clients, daemon(texts[1]) as without:
        time.sleep(UP_S)
        for each in (with_clients, without):
            for axis in ("m1", "m2"):
                ask(control(each), "do", device=axis, name="enable", parameters={})
        for kind in KINDS:
            measure(kind, with_clients, without, numbers[0])


if __name__ == "__main__":
    main()
