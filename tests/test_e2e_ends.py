"""Ends: SIGTERM ends a daemon within two seconds whatever runs, and work ends with its client."""

import base64
import json
import os
import resource
import signal
import socket
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress

import pytest
from e2e_support import FAULTS_OF_OURS, PATIENCE_S, Place, Server, config, free_port, until

pytestmark = pytest.mark.long

ENDS_S = 2.0
SAC = {"profile": "sac", "flash": {}}
MACHINE = """machine: plotter
axes:
  x: {axis: m1, deg_per_mm: 9, min_mm: 0, max_mm: 9, velocity_mm_per_min: 6000, acceleration_mm_per_s2: 1000}
"""
LONG_DRAWING = {"text": "G21 G91 F6000\n" + "G1X.001\nG1X-.001\n" * 60_000 + "M2\n", "machine": MACHINE}
STEPS = [{"move": {"m1": number % 7}} for number in range(9999)]
LONG_RUN = json.dumps({"run": "long", "axes": {"m1": {}}, "steps": STEPS})
FAR_RUN = json.dumps({"run": "far", "axes": {"m1": {}}, "steps": [{"move": {"m1": 72000}}]})


class Bench:
    """A daemon with all doors, and clients that stay until the test's end."""

    def __init__(self, place: Place, stack: ExitStack) -> None:
        self.place, self._stack = place, stack
        self.web, self.modbus, self.zenoh = free_port(), free_port(), free_port()
        bridges = {
            "web": {"listen": self.web},
            "modbus": {"listen": f"127.0.0.1:{self.modbus}"},
            "zenoh": {"listen": [f"tcp/127.0.0.1:{self.zenoh}"], "packed_hz": 500},
        }
        text = config(
            devices={"m1": {}, "s1": SAC, "s2": SAC},
            segments={"bus0": {"stations": ["s1", "s2"], "taps": {"a": {"port": "pty"}}}},
            faults=[{"fault": "node_babble", "target": "bus0.a", "bytes": 100, "every_ms": 12}],
            bridges=bridges,
        )
        self.server: Server = place.serve(text, preexec_fn=_small_files)

    def keep(self, client: socket.socket) -> socket.socket:
        return self._stack.enter_context(client)

    def asks(self, verb: str, **given: object) -> None:
        """Ask at the control socket, and do not wait for the answer."""
        client = self.keep(socket.socket(socket.AF_UNIX))
        client.connect(str(self.server.control))
        client.sendall(json.dumps({"verb": verb, **given}).encode() + b"\n")

    def page(self, *requests: dict[str, object]) -> None:
        """Open a page that asks and never reads."""
        client = self.keep(socket.socket())
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        client.connect(("127.0.0.1", self.web))
        key = base64.b64encode(os.urandom(16)).decode()
        lines = [
            "GET /ws HTTP/1.1",
            f"Host: 127.0.0.1:{self.web}",
            "Connection: Upgrade",
            "Upgrade: websocket",
        ]
        lines += [f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Protocol: hil.v1"]
        client.sendall("\r\n".join([*lines, "", ""]).encode())
        assert client.recv(12) == b"HTTP/1.1 101"
        with suppress(ConnectionError):  # the door may have cut it off already
            for number, request in enumerate(requests):
                data = json.dumps({"id": number, **request}).encode()
                client.sendall(b"\x81\xff" + struct.pack(">Q", len(data)) + bytes(4) + data)


def _small_files() -> None:
    """Let no file be longer than 64 kB: as a disk that is full."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536))


def planning(bench: Bench) -> None:
    for _ in range(4):
        bench.asks("drawing", **LONG_DRAWING)
    bench.page({"do": "ask", "operation": "drawing", "given": LONG_DRAWING})


def runs(bench: Bench) -> None:
    for _ in range(6):
        bench.asks("run", text=LONG_RUN, check=True)
    bench.server.ask("do", device="m1", name="enable", parameters={})
    bench.server.ask("run", text=FAR_RUN)
    bench.asks("wait", device="m1", effective_at_ns=0)


def deaf_pages(bench: Bench) -> None:
    watches = [("samples", "m1"), ("packets", "bus0"), ("bytes", "m1"), ("status", ""), ("faults", "")]
    asked = [{"do": "watch", "what": what, "target": of, "fields": ["r"]} for what, of in watches]
    for row in asked[1:]:
        del row["fields"]
    for _ in range(50):
        bench.page(*asked, *[{"do": "ask", "operation": "status"}] * 20)


def captures(bench: Bench) -> None:
    watch = {"do": "watch", "what": "packets", "target": "bus0"}
    for _ in range(20):
        bench.page(watch, *[{"do": "export", "watch": 1}] * 20)
        bench.asks("capture", ports=["bus0", "m1"])


def terminals(bench: Bench) -> None:
    for _ in range(10):
        bench.page(*({"do": "open", "port": port} for port in ("m1", "s1", "bus0.a")))


def watchers(bench: Bench) -> None:
    for number in range(200):
        bench.server.ask("watch", device="m1", signals=[], interval_ns=1_000_000 + number % 7)


def modbus_clients(bench: Bench) -> None:
    for _ in range(60):
        client = bench.keep(socket.create_connection(("127.0.0.1", bench.modbus)))
        client.setblocking(False)
        with suppress(BlockingIOError):
            for _ in range(5000):
                client.send(b"\0\1\0\0\0\6\1\4\0\0\0\x20")


def zenoh_clients(bench: Bench) -> None:
    from plain_zenoh import Plain

    plain = Plain(bench.zenoh)
    plain.listen("**")
    for _ in range(200):
        plain.session.get("hil/t/**", timeout=PATIENCE_S)
    key, payload = "hil/t/axis/m1/cmd/move_abs?done=true", '{"position_deg": 1e5}'
    plain.session.get(key, payload=payload, timeout=PATIENCE_S)
    bench._stack.callback(plain.session.close)


def commits(bench: Bench) -> None:
    for name in ("s1", "s2"):
        bench.server.ask("send", device=name, data=b"&w1\r".hex())


def all_of_it(bench: Bench) -> None:
    for begin in (planning, runs, captures, terminals, watchers, commits):
        begin(bench)


WHATEVER: tuple[Callable[[Bench], None], ...] = (
    planning,
    runs,
    deaf_pages,
    captures,
    terminals,
    watchers,
    modbus_clients,
    zenoh_clients,
    commits,
    all_of_it,
)


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Place() as place, ExitStack() as stack:
        yield Bench(place, stack)


@pytest.mark.thorough
@pytest.mark.parametrize("begin", WHATEVER, ids=lambda begin: begin.__name__)
def test_sigterm_ends_it_soon_whatever_runs(bench: Bench, begin: Callable[[Bench], None]) -> None:
    begin(bench)
    bench.server.ask("health")  # all that was asked has reached it
    time.sleep(0.3)  # for threads and processes that have to start
    began_s = time.monotonic()
    bench.server.process.send_signal(signal.SIGTERM)
    code = bench.server.process.wait(PATIENCE_S)
    took_s = time.monotonic() - began_s
    said = bench.server.output
    assert code == 0, said
    assert not any(word in said for word in FAULTS_OF_OURS), said[-3000:]
    print(f"{begin.__name__}: {took_s:.2f} s")
    assert took_s < ENDS_S, said[-2000:]


def test_who_asks_at_the_control_socket_is_answered_without_a_file_left(bench: Bench) -> None:
    pid, in_use = bench.server.pid, f"/proc/{bench.server.pid}/fd"
    most = len(os.listdir(in_use)) + 20
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (most, most))
    for _ in range(60):
        bench.keep(socket.create_connection(("127.0.0.1", bench.modbus)))
    until(lambda: len(os.listdir(in_use)) == most, "files")
    for _ in range(5):
        problems = bench.server.ask("status")["health"]["problems"]
        assert any(each["kind"] == "descriptors" for each in problems)
    bench.server.stop()


def test_work_at_the_control_socket_ends_with_its_client(bench: Bench) -> None:
    def planners() -> list[str]:
        with open(f"/proc/{bench.server.pid}/task/{bench.server.pid}/children") as file:
            return file.read().split()

    client = socket.socket(socket.AF_UNIX)
    client.connect(str(bench.server.control))
    client.sendall(json.dumps({"verb": "drawing", **LONG_DRAWING}).encode() + b"\n")
    until(planners, "a process that plans")
    client.close()
    until(lambda: not planners(), "its end", 5.0)
