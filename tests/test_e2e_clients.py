"""Clients that misbehave, and what the device beside theirs notices of it: nothing."""

import random
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from e2e_support import PATIENCE_S, Q_BYTES, Client, Place, Server, config, until

TCP = {"port": {"kind": "tcp", "listen": 0}}
PORTS = pytest.mark.parametrize("port", [{"port": "pty"}, TCP], ids=["pty", "tcp"])
ANSWER_S = 10.0
"""Bound for an answer that takes 0.1 s of simulated time, beside a flood; a loaded machine took 3.5 s."""


class Neighbour:
    """Talks to another device of the bench all the time; ``worst_s`` is its longest wait for an answer."""

    def __init__(self, server: Server) -> None:
        self._client = server.client("m2")
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._talk)
        self.waits_s: list[float] = []
        self.wrong: list[object] = []

    def _talk(self) -> None:
        while not self._end.is_set():
            start = time.monotonic()
            try:
                answer = self._client.ask(b"p")
            except AssertionError as error:
                self.wrong.append(error)
                return
            self.waits_s.append(time.monotonic() - start)
            if not re.fullmatch(rb"stepNumber: 0 , Angle: \d+\.\d\d, raw encoder: \d+\r\n", answer):
                self.wrong.append(answer)

    def __enter__(self) -> "Neighbour":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join(2 * PATIENCE_S)
        self._client.close()
        assert not self._thread.is_alive()

    def undisturbed(self) -> None:
        assert self.wrong == []
        assert self.waits_s
        assert max(self.waits_s) < ANSWER_S


@pytest.fixture
def pair(place: Place, request: pytest.FixtureRequest) -> Server:
    """A server with m1 on the parametrized port and m2 on a pty."""
    return place.serve(config(speed=100, devices={"m1": request.param, "m2": {}})).ready()


PAIRS = pytest.mark.parametrize("pair", [{"port": "pty"}, TCP], ids=["pty", "tcp"], indirect=True)


def resident_kB(server: Server) -> int:
    text = Path(f"/proc/{server.pid}/status").read_text()
    return int(text.split("VmRSS:")[1].split()[0])


def open_files(server: Server) -> int:
    return len(list(Path(f"/proc/{server.pid}/fd").iterdir()))


@PAIRS
def test_a_client_that_never_reads(pair: Server) -> None:
    """The client is held up; memory does not grow with what it asks for, nothing is lost, and its neighbour
    does not notice."""
    before_kB = resident_kB(pair)
    with Neighbour(pair) as neighbour, pair.client("m1") as client:
        asked = client.write_until_full(b"q" * 10_000_000)
        until(lambda: pair.status("m1")["backlog_bytes"] > 65536, "a backlog")
        until(lambda: len(neighbour.waits_s) > 50, "answers to the neighbour")
        assert resident_kB(pair) - before_kB < 40_000
        row = pair.status("m1")
        assert row["dropped_bytes"] == 0
        assert row["rx_bytes"] < 1000
        assert asked > row["rx_bytes"]
        # It reads again, a little: whole answers.
        answers = client.read_exactly(100 * Q_BYTES)
        assert answers == answers[:Q_BYTES] * 100
        assert pair.status("m1")["dropped_bytes"] == 0
        client.close()
        until(lambda: pair.status("m1")["clients"] == 0, "the end of the client")
    neighbour.undisturbed()
    pair.ask("reset", device="m1")


@pytest.mark.thorough
@PAIRS
def test_a_binary_flood(pair: Server) -> None:
    """200 kB of all bytes but those of the commands that take long, among them q's 100 MB of answers; of
    those that take 100 ms only some."""
    chance = random.Random(7)
    quick = bytes(set(range(256)) - set(b"cwgjaqpsy"))
    data = bytes(chance.choices(quick, k=180_000) + chance.choices(quick + b"psy", k=20_000))
    with Neighbour(pair) as neighbour, pair.client("m1") as client:
        for at in range(0, len(data), 4096):
            client.write(data[at : at + 4096], timeout_s=60)
            client.got.clear()
        # 5 s on an idle machine, 30 beside six busy processes on two cores.
        taken = lambda: (client.quiet(0.01), pair.status("m1")["rx_bytes"] == len(data))[1]  # noqa: E731
        until(taken, "the flood's end", timeout_s=120)
        boot(pair, client)
    neighbour.undisturbed()
    row = pair.status("m1")
    assert (row["failed"], row["dropped_bytes"]) == (None, 0)


def boot(server: Server, client: Client) -> None:
    """Switch m1 off and on; then it answers as ever."""
    server.ask("reset", device="m1")
    client.read_until(b"SPI communication with AS5047 encoder...\r\n")
    client.quiet(0.1)  # commands that were still on their way
    server.ask("reset", device="m1")
    client.read_until(b"SPI communication with AS5047 encoder...\r\n")
    assert client.ask(b"p").startswith(b"stepNumber: 0 ")


@PAIRS
def test_a_flood_of_all_bytes_and_a_hang_up(pair: Server) -> None:
    """Hours of calibrations and the like, from a client that has gone long before they are done."""
    data = random.Random(8).randbytes(200_000)
    with Neighbour(pair) as neighbour:
        with pair.client("m1") as client:
            client.write_until_full(data)
            until(lambda: pair.status("m1")["rx_bytes"] > 0, "the flood's begin")
        until(lambda: len(neighbour.waits_s) > 50, "answers to the neighbour")
    neighbour.undisturbed()
    assert pair.status("m1")["failed"] is None


def test_half_numbers(place: Place) -> None:
    """Expect that the number is taken 1,000 ms after its last byte: a quarter of a second at speed 4."""
    server = place.serve(config(speed=4)).ready()
    with server.client() as client:
        for typed, number in ((b"r12", b"12.00"), (b"r-3.5", b"-3.50"), (b"r\n", b"0.00"), (b"r-", b"0.00")):
            start = time.monotonic()
            client.write(typed)
            assert client.read_until(b"\r\n") == b"Enter setpoint:\r\n"
            assert client.read_until(b"\r\n") == number + b"\r\n"
            assert 0.2 < time.monotonic() - start < 0.25 + ANSWER_S
        client.write(b"kpp7")
        assert b"new pKp = 7.0000000000\r\n" in client.read_until(b"new pKp = 7.0000000000\r\n")
        client.read_until(b"q ----- quit\r\n\r\n")
        assert b"done..." in client.ask(b"q", b"done...\r\n\r\n")


STORM = """
import os, select, signal, socket, sys
address, connects = sys.argv[1], int(sys.argv[2])

def connected():
    if not address.startswith("socket://"):
        return os.open(address, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    host, port = address.removeprefix("socket://").split(":")
    connection = socket.create_connection((host, int(port)))
    if number % 3 == 0:  # hangs up by a reset
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\\1\\0\\0\\0\\0\\0\\0\\0")
    return connection.detach()

for number in range(connects):
    if number % 10:
        fd = connected()
        if number % 2:
            os.write(fd, b"p")
        if address.startswith("socket://"):
            socket.socket(fileno=fd).close()
        else:
            os.close(fd)
        continue
    ready, tell = os.pipe()
    child = os.fork()
    if not child:
        fd = connected()
        os.write(fd, b"qqqq")
        os.write(tell, b"!")
        select.select([], [], [], 60)
        os._exit(1)
    os.read(ready, 1)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.close(ready)
    os.close(tell)
"""


@PAIRS
def test_a_thousand_connects_some_killed(pair: Server) -> None:
    address = pair.ask("list")["devices"][0]["address"]
    with pair.client("m1") as client:
        client.ask(b"p")
    until(lambda: pair.status("m1")["clients"] == 0, "the client's end")
    files = open_files(pair)
    with Neighbour(pair) as neighbour:
        subprocess.run([sys.executable, "-c", STORM, address, "1000"], timeout=60, check=True)
        until(lambda: pair.status("m1")["clients"] == 0, "the end of all clients")
    neighbour.undisturbed()
    row = pair.status("m1")
    # The kernel merges what two clients of a pty do in the same microsecond.
    assert 950 <= row["connects"] <= 1002
    assert row["failed"] is None
    assert row["port_failure"] is None
    assert until(lambda: open_files(pair) <= files, "files to be closed")
    with pair.client("m1") as client:
        until(lambda: client.quiet(2) == b"", "the end of the answers to commands of clients that are gone")
        assert client.ask(b"p").startswith(b"stepNumber: 0 , Angle: ")
