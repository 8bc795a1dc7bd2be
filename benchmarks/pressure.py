"""Wakes that the core of a daemon misses while its ports, files and clients are pressed upon, against a
cyclictest on the same CPU at the same time, both SCHED_FIFO 80.

The argument is how many seconds each pressure takes (15).
"""

import json
import os
import resource
import select
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from _processes import Daemon, daemon, have
from _report import check_work, is_quick, report
from wake_latency import MISSED_LIMIT, cyclictest, of_cyclictest

from hil.net.control_client import ask

RATE_HZ = 1000
DEAF, SILENT = 32, 1000
FEW_FILES = 96
FLOOD = """
import os, socket, sys
host, _, number = sys.argv[1].partition("://")[2].rpartition(":")
client = socket.create_connection((host, int(number))) if number else None
fd = client.fileno() if client else os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
block = bytes.fromhex(sys.argv[2]) * 16384
while True:
    os.write(fd, block)
"""


def config(cpu: int, extra: int = 0) -> str:
    devices: dict[str, object] = {
        "a": {"profile": "sac", "port": "tcp"},
        "b": {"profile": "mechaduino", "port": "rfc2217"},
        "c": {"profile": "sac", "port": "pty"},
        "d": {"profile": "mechaduino", "port": "tcp", "flash": {"table": "identity"}},
        "e": {"profile": "sac", "port": "tcp"},
    }
    if extra:
        devices[f"x{extra}"] = {"profile": "mechaduino"}
    return json.dumps({"bench": "bench", "cpu": cpu, "rate_hz": RATE_HZ, "devices": devices})


class Bench:
    """Bench of the daemon that is put under pressure, with ways to reach it."""

    def __init__(self, running: Daemon, cpu: int) -> None:
        self.running = running
        self.cpu = cpu
        self.control = running.folder / "run" / "bench" / "control.sock"

    def address(self, device: str) -> str:
        rows = ask(self.control, "status")["devices"]
        return next(str(row["address"]) for row in rows if row["device"] == device)

    def connect(self, device: str) -> socket.socket:
        host, _, number = self.address(device).partition("://")[2].rpartition(":")
        return socket.create_connection((host, int(number)), timeout=5)


@contextmanager
def flood(bench: Bench, device: str, payload: bytes) -> Iterator[None]:
    """A program that writes to a board as fast as it can, and does not read."""
    process = subprocess.Popen([sys.executable, "-c", FLOOD, bench.address(device), payload.hex()])
    try:
        yield
    finally:
        process.kill()
        process.wait()


@contextmanager
def deaf(bench: Bench) -> Iterator[None]:
    """Clients that have asked for megabytes and do not read them."""
    with ExitStack() as stack:
        clients = [stack.enter_context(bench.connect("d")) for _ in range(DEAF)]
        clients[0].send(b"q" * 100)
        yield


@contextmanager
def silent(bench: Bench) -> Iterator[None]:
    """Clients of the control socket that come and say nothing."""
    with ExitStack() as stack:
        for _ in range(SILENT):
            stack.enter_context(socket.socket(socket.AF_UNIX)).connect(str(bench.control))
        yield


@contextmanager
def no_files(bench: Bench) -> Iterator[None]:
    """Take all descriptors from the daemon, which can open nothing more."""
    limits = resource.prlimit(bench.running.pid, resource.RLIMIT_NOFILE)
    resource.prlimit(bench.running.pid, resource.RLIMIT_NOFILE, (FEW_FILES, limits[1]))
    try:
        with ExitStack() as stack:
            for device in ("a", "b", "d"):
                for _ in range(DEAF):
                    stack.enter_context(bench.connect(device))
            yield
    finally:
        resource.prlimit(bench.running.pid, resource.RLIMIT_NOFILE, limits)


@contextmanager
def again_and_again(do: Callable[[int], None]) -> Iterator[None]:
    is_over = threading.Event()

    def work() -> None:
        number = 0
        while not is_over.is_set():
            number += 1
            do(number)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


@contextmanager
def reloads(bench: Bench) -> Iterator[None]:
    """Add and remove a board by reloads, again and again."""
    path = bench.running.folder / "bench.yaml"

    def reload(number: int) -> None:
        path.write_text(config(bench.cpu, number))
        ask(bench.control, "reload")

    with again_and_again(reload):
        yield


@contextmanager
def saves(bench: Bench) -> Iterator[None]:
    """Let a board write its memory, again and again."""
    with bench.connect("e") as client:

        def save(number: int) -> None:
            client.sendall(b"$Cd%d\r" % (number % 100 + 1))
            heard = b""
            while not heard.endswith(b"SAC>") and select.select([client], [], [], 5)[0]:
                heard += client.recv(4096)

        with again_and_again(save):
            yield


PRESSURES = {
    "nothing": lambda bench: ExitStack(),
    "flood at a tcp port": lambda bench: flood(bench, "a", b"x"),
    "flood at an rfc2217 port": lambda bench: flood(bench, "b", b"\xff\xfd\x2c"),
    "flood at a pty": lambda bench: flood(bench, "c", b"V\r"),
    "deaf clients": deaf,
    "silent control clients": silent,
    "no file descriptor left": no_files,
    "reloads": reloads,
    "memory saves": saves,
}


def counts(bench: Bench) -> tuple[int, int]:
    status = ask(bench.control, "status")
    return status["ticks"], status["missed"]


def main() -> None:
    """Run each kind of pressure on a daemon of its own."""
    if not have("cyclictest", "rt-tests"):
        return
    numbers = [float(word) for word in sys.argv[1:] if word.isdigit()]
    seconds = numbers[0] if numbers else 3.0 if is_quick() else 15.0
    cpu = max(os.sched_getaffinity(0))
    rows: dict[str, tuple[int, int, int]] = {}
    for name, press in PRESSURES.items():
        with daemon(config(cpu)) as running:
            bench = Bench(running, cpu)
            while ask(bench.control, "status")["sim_ns"] < 6_000_000_000:
                time.sleep(0.1)
            with press(bench):
                before = counts(bench)
                theirs = of_cyclictest(cyclictest(cpu, 1_000_000 // RATE_HZ, seconds), 1_000_000 // RATE_HZ)
                ticks, missed = (now - then for now, then in zip(counts(bench), before, strict=True))
        check_work(f"wakes of the core, {name}", ticks + missed, RATE_HZ * seconds, 0.2)
        rows[name] = (ticks, missed, theirs.missed)
        print(f"  {name}: {missed} of {ticks} missed, cyclictest {theirs.missed}", flush=True)
    ticks, missed, beside = (sum(row[i] for row in rows.values()) for i in range(3))
    extra: dict[str, object] = {"reference": "a cyclictest on the same CPU at the same time", "rows": rows}
    report("missed_under_pressure", missed / ticks, "of all", beside / ticks, None, extra)
    share = (missed - beside) / ticks
    verdict = "yes" if share <= MISSED_LIMIT else "NO"
    print(f"  beyond cyclictest's: {100 * share:.4f} % (<= {100 * MISSED_LIMIT:g} %: {verdict})")


if __name__ == "__main__":
    main()
