"""Overload of files, clients and bytes: the boards that are left alone notice nothing of it.

Boards are compared with the same ones of another daemon, beside it at the same time, for whatever else runs
on the machine, or takes its CPUs away, disturbs both: their times to answer, and the wakes that the cores
missed on one CPU. Disturbances by others pass: of several looks one has to be good. Those by the daemon
itself do not.
"""

import json
import os
import resource
import select
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from e2e_support import Client, Place, Server, config, until

from hil.net.traffic import QUEUE_BYTES

SAC = {"profile": "sac", "flash": {}}
ROUNDS = 200
LOOKS = 5
RECOVERY_S = 2.0
FEW_FILES = 96
FLOOD = """
import os, select, socket, sys, time
address, payload, seconds = sys.argv[1], bytes.fromhex(sys.argv[2]), float(sys.argv[3])
host, _, number = address.partition("://")[2].rpartition(":")
client = socket.create_connection((host, int(number))) if number else None
fd = client.fileno() if client else os.open(address, os.O_RDWR | os.O_NOCTTY)
os.set_blocking(fd, False)
block = payload * (65536 // len(payload))
print("ready", flush=True)
sys.stdin.readline()
end_s = time.monotonic() + seconds
while time.monotonic() < end_s:
    if select.select([], [fd], [], 0.05)[1]:
        os.write(fd, block)
"""


def bench(name: str = "t", /, **ports: str) -> str:
    """Configuration of two boards that are left alone and those that are pressed upon, at the wall's pace."""
    devices = {name: SAC | {"port": kind} for name, kind in ({"calm": "tcp", "quiet": "pty"} | ports).items()}
    return config(name, speed=1, devices=devices)


def times_s(groups: Sequence[Sequence[Client]]) -> list[list[float]]:
    """Times that boards take to answer an empty line, one after the other, for each group of them."""
    found: list[list[float]] = [[] for _ in groups]
    for _ in range(ROUNDS):
        for times, clients in zip(found, groups, strict=True):
            for client in clients:
                began_s = time.perf_counter()
                client.ask(b"\r", b"SAC>")
                times.append(time.perf_counter() - began_s)
    return found


def high_s(times: list[float]) -> float:
    return statistics.quantiles(times, n=100)[98]


def missed(server: Server) -> int:
    return int(server.ask("status")["missed"])


def cpu_s(server: Server) -> float:
    fields = Path(f"/proc/{server.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def rss_MB(server: Server) -> float:
    fields = Path(f"/proc/{server.pid}/statm").read_text().split()
    return int(fields[1]) * resource.getpagesize() / 1e6


class Calm:
    """The boards that are left alone, of the daemon that is pressed upon and of another one."""

    def __init__(self, place: Place, server: Server, more_MB: float = 40) -> None:
        """Begin the comparison. ``more_MB``: memory that the pressure may cost."""
        self._more_MB = more_MB
        self._servers = (server, place.serve(bench("beside"), bench="beside").ready("calm"))
        self._clients = [[each.client(name) for name in ("calm", "quiet")] for each in self._servers]
        for clients in self._clients:
            for client in clients:
                client.quiet(0.05)
        self._rss_MB = rss_MB(server)

    def __enter__(self) -> "Calm":
        return self

    def __exit__(self, *_: object) -> None:
        for clients in self._clients:
            for client in clients:
                client.close()

    def is_undisturbed(self) -> None:
        """Assert that the boards answer within twice the others' times, and that the core keeps its time."""
        looks = [look := self._look()]
        while look and len(looks) < LOOKS:
            looks.append(look := self._look())
        assert not look, looks
        assert rss_MB(self._servers[0]) < self._rss_MB + self._more_MB

    def _look(self) -> str:
        """Description of what is worse here than beside it, "" for nothing."""
        before = [missed(server) for server in self._servers]
        here_s, beside_s = times_s(self._clients)
        here, beside = (missed(server) - then for server, then in zip(self._servers, before, strict=True))
        said = f"missed {here}, beside it {beside}"
        is_bad = here > 2 * beside + 20
        for what, figure, slack_s in (("median", statistics.median, 0.0005), ("99 of 100", high_s, 0.002)):
            said += f"; {what} {figure(here_s) * 1e3:.2f} ms, beside it {figure(beside_s) * 1e3:.2f} ms"
            is_bad |= figure(here_s) > 2 * figure(beside_s) + slack_s
        print(f"{said}; {rss_MB(self._servers[0]):.1f} MB")
        return said if is_bad else ""


def few_files() -> None:
    resource.setrlimit(resource.RLIMIT_NOFILE, (FEW_FILES, FEW_FILES))


def connect(server: Server, device: str) -> socket.socket:
    host, _, number = server.status(device)["address"].partition("://")[2].rpartition(":")
    return socket.create_connection((host, int(number)), timeout=20)


def warnings(server: Server, about: str) -> list[str]:
    return [line for line in server.output.splitlines() if line.startswith("WARNING") and about in line]


@contextmanager
def flood(server: Server, device: str, payload: bytes, seconds: float) -> Iterator[None]:
    """Run a program that writes to a board as fast as it can, without reading."""
    command = [sys.executable, "-c", FLOOD, server.status(device)["address"], payload.hex(), str(seconds)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin
        assert process.stdout
        assert process.stdout.readline() == b"ready\n"
        process.stdin.write(b"\n")
        process.stdin.flush()
        try:
            yield
        finally:
            process.kill()


@pytest.mark.parametrize(
    ("kind", "payload"), [("tcp", b"x"), ("tcp", b"V\r"), ("rfc2217", b"\xff\xfd\x2c"), ("pty", b"V\r")]
)
def test_a_flood_at_one_port(place: Place, kind: str, payload: bytes) -> None:
    server = place.serve(bench(pressed=kind)).ready("pressed")
    with Calm(place, server) as calm:
        with flood(server, "pressed", payload, 60):
            calm.is_undisturbed()
        # What the kernel still holds of it is read on, at the line's pace.
        calm.is_undisturbed()


def test_clients_that_stop_reading(place: Place) -> None:
    """Open all clients that one port may have, with more asked for than their sockets take."""
    text = json.loads(bench())
    text["devices"]["pressed"] = {"profile": "mechaduino", "port": "tcp", "flash": {"table": "identity"}}
    server = place.serve(json.dumps(text)).ready("pressed")
    with Calm(place, server, 32 * QUEUE_BYTES / 1e6 + 40) as calm:
        with ExitStack() as stack:
            deaf = [stack.enter_context(connect(server, "pressed")) for _ in range(32)]
            until(lambda: server.status("pressed")["clients"] == 32, "the clients")
            deaf[0].send(b"q" * 100)
            until(lambda: server.status("pressed")["backlog_bytes"] > 0, "a backlog")
            calm.is_undisturbed()
            with connect(server, "pressed") as late:
                assert late.recv(1) == b""
            assert server.status("pressed")["turned_away"] == 1
            assert server.status("pressed")["dropped_bytes"] == 0  # the board is held up instead
        ended_s = time.monotonic()
        until(lambda: server.status("pressed")["clients"] == 0, "the clients' end", RECOVERY_S)
        with server.client("pressed") as client:
            client.ask(b"r", b"setpoint:\r\n")
        print(f"{time.monotonic() - ended_s:.2f} s to recover")
    assert len(warnings(server, "tcp port of pressed")) == 1


def test_no_file_descriptor_is_left(place: Place) -> None:
    """Open clients of ports, then of the control socket, until nothing more can be opened."""
    devices = {name: "tcp" for name in ("a", "b", "c")}
    server = place.serve(bench(**devices), preexec_fn=few_files).ready("a")
    with Calm(place, server) as calm:
        with ExitStack() as stack:
            for name in devices:
                for _ in range(32):
                    stack.enter_context(connect(server, name))
            until(lambda: sum(server.status(n)["turned_away"] for n in devices) > 0, "clients turned away")
            with connect(server, "calm") as late:
                assert late.recv(1) == b""
            for _ in range(2 * FEW_FILES):
                silent = stack.enter_context(socket.socket(socket.AF_UNIX))
                silent.connect(str(server.control))
            until(lambda: warnings(server, "control socket"), "the limit at the control socket")
            server.ask("status")  # those who ask are let in before those who only come
            busy_s, began_s = cpu_s(server), time.monotonic()
            select.select([], [], [], 1.5)
            share = (cpu_s(server) - busy_s) / (time.monotonic() - began_s)
            assert share < 0.5, "it is busy with nothing"
            calm.is_undisturbed()
        ended_s = time.monotonic()
        until(lambda: server.status("a")["clients"] == 0, "the clients' end", RECOVERY_S)
        with server.client("a") as client:
            client.ask(b"\r", b"SAC>")
        print(f"{time.monotonic() - ended_s:.2f} s to recover, {share:.0%} of a CPU")
        assert time.monotonic() - ended_s < RECOVERY_S
        calm.is_undisturbed()
    assert "Traceback" not in server.output
    for about in (
        "tcp port of a:",
        "tcp port of b:",
        "tcp port of c:",
        "tcp port of calm:",
        "control socket:",
    ):
        assert len(warnings(server, about)) <= 1, about


def test_a_thousand_silent_clients_of_the_control_socket(place: Place) -> None:
    server = place.serve(bench()).ready("calm")
    with Calm(place, server) as calm, ExitStack() as stack:
        steady = stack.enter_context(socket.socket(socket.AF_UNIX))
        steady.connect(str(server.control))
        steady.sendall(b'{"verb": "list"}\n')
        assert steady.makefile("rb").readline().startswith(b'{"ok": true')
        for number in range(1000):
            silent = stack.enter_context(socket.socket(socket.AF_UNIX))
            silent.connect(str(server.control))
            if number % 100 == 0:
                assert server.ask("list")["bench"] == "t"
        calm.is_undisturbed()
        steady.sendall(b'{"verb": "list"}\n')  # who has asked before is let go last
        assert steady.makefile("rb").readline().startswith(b'{"ok": true')
    assert len(warnings(server, "control socket: 64 clients")) == 1
    assert len(os.listdir(f"/proc/{server.pid}/fd")) < 120
    until(lambda: len(os.listdir(f"/proc/{server.pid}/fd")) < 60, "the files' end", RECOVERY_S)
