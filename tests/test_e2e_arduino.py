"""The Arduino IDE as hil meets it: its discovery and its monitor as processes, on a running bench; and the
touch at 1200 baud that begins an upload."""

import json
import os
import select
import shlex
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from typing import Any

import pytest
import serial
from e2e_support import PATIENCE_S, Client, Place, Server, config, until

from hil.sim.input_reading import decode, read_line
from hil.sim.inputs import Reset

TCP = {"port": {"kind": "tcp", "listen": 0}}
HELLO = 'HELLO 1 "Arduino IDE 2.3.4"'
MENU_END = b"m  -  print main menu\r\n"


class Tool:
    """One of the programs that the IDE starts."""

    def __init__(self, recipe: str) -> None:
        pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        self._process = subprocess.Popen(shlex.split(recipe), **pipes)
        self._pending = b""

    def say(self, line: str) -> dict[str, Any]:
        """Send one command, and return its answer."""
        assert self._process.stdin
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()
        return self.hear()

    def hear(self, timeout_s: float = PATIENCE_S) -> dict[str, Any]:
        """The next message."""
        assert self._process.stdout
        deadline = time.monotonic() + timeout_s
        while b"\n" not in self._pending:
            left_s = deadline - time.monotonic()
            assert left_s > 0, "no message"
            if select.select([self._process.stdout], [], [], left_s)[0]:
                data = os.read(self._process.stdout.fileno(), 65536)
                assert data, "the program has ended"
                self._pending += data
        line, _, self._pending = self._pending.partition(b"\n")
        message: dict[str, Any] = json.loads(line)
        return message

    def ended(self) -> int:
        """Wait for the tool's end, and return its exit code. It has said nothing more."""
        assert self._process.stdout
        code = self._process.wait(PATIENCE_S)
        assert self._pending + self._process.stdout.read() == b""
        return code

    def terminate(self) -> None:
        """End it as the IDE 1.8 does."""
        self._process.terminate()

    def hang_up(self) -> None:
        assert self._process.stdin
        self._process.stdin.close()

    def close(self) -> None:
        self._process.kill()
        self._process.wait(PATIENCE_S)
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe
            pipe.close()


class Tools:
    """Starts the IDE's tools as ``hil arduino install`` says, and ends them."""

    def __init__(self, place: Place) -> None:
        book, runtime = place.folder / "sketchbook", str(place.runtime)
        place.cli("arduino", "install", "--sketchbook", str(book), "--runtime-dir", runtime)
        lines = (book / "hardware/hil/virtual/platform.txt").read_text().splitlines()[1:]
        self._platform = dict(line.split("=", 1) for line in lines)
        self.started: list[Tool] = []

    def discovery(self) -> Tool:
        return self._greeted("pluggable_discovery.hil.pattern")

    def discovery_of_ide_1_8(self) -> Tool:
        """That of the IDE 1.8, which begins without HELLO."""
        self.started.append(Tool(self._platform["discovery.hil.pattern"]))
        return self.started[-1]

    def monitor(self) -> Tool:
        return self._greeted("pluggable_monitor.pattern.hil")

    def _greeted(self, key: str) -> Tool:
        tool = Tool(self._platform[key])
        self.started.append(tool)
        assert tool.say(HELLO) == {"eventType": "hello", "protocolVersion": 1, "message": "OK"}
        return tool


@pytest.fixture
def tools(place: Place) -> Iterator[Tools]:
    made = Tools(place)
    yield made
    for tool in made.started:
        tool.close()


class Ide:
    """IDE's end of its serial monitor, which listens for it."""

    def __init__(self) -> None:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.settimeout(PATIENCE_S)
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"

    def accept(self) -> Client:
        """The monitor's connection."""
        return Client(self._listener.accept()[0])

    def __enter__(self) -> "Ide":
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.close()


@pytest.mark.parametrize("port", [{}, TCP], ids=["pty", "tcp"])
def test_a_session_of_the_ide(place: Place, tools: Tools, port: dict[str, Any]) -> None:
    server = place.serve(config(devices={"m1": port})).ready()
    discovery = tools.discovery()
    assert discovery.say("START_SYNC") == {"eventType": "start_sync", "message": "OK"}
    added = discovery.hear()
    address = server.ask("list")["devices"][0]["address"]
    assert added == {
        "eventType": "add",
        "port": {
            "address": address,
            "label": "t/m1",
            "protocol": "hil",
            "protocolLabel": "Virtual board (hil)",
            "hardwareId": "hil/t/m1",
            "properties": {"bench": "t", "device": "m1", "profile": "mechaduino", "hardware": "0.1"},
        },
    }
    monitor = tools.monitor()
    assert monitor.say("DESCRIBE")["port_description"]["protocol"] == added["port"]["protocol"]
    assert monitor.say("CONFIGURE baudrate 9600") == {"eventType": "configure", "message": "OK"}
    with Ide() as ide:
        assert monitor.say(f"OPEN {ide.address} {address}") == {"eventType": "open", "message": "OK"}
        with ide.accept() as board:
            menu = board.ask(b"m", MENU_END)
            assert b"----- Mechaduino" in menu
            assert monitor.say("CONFIGURE baudrate 57600")["message"] == "OK"
            board.ask(b"j", b"\r\n1...\r\n")
            # A number a line, as the serial plotter wants it; degrees * 1024 of a turn's 360.
            samples = [int(board.read_until(b"\r\n")) for _ in range(650)]
            assert all(0 <= sample < 360 * 1024 for sample in samples)
            assert server.status()["clients"] == 1
            assert monitor.say("CLOSE") == {"eventType": "close", "message": "OK"}
            until(lambda: server.status()["clients"] == 0, "the port to be closed")
            board.quiet(0.1)
            assert os.read(board.fd, 1) == b""
    assert monitor.say("QUIT") == {"eventType": "quit", "message": "OK"}
    assert monitor.ended() == 0
    server.stop()
    removed = {"eventType": "remove", "port": {"address": address, "protocol": "hil"}}
    assert discovery.hear() == removed
    assert discovery.say("QUIT") == {"eventType": "quit", "message": "OK"}
    assert discovery.ended() == 0


@pytest.mark.thorough
def test_benches_come_and_go_and_one_is_stopped(place: Place, tools: Tools) -> None:
    discovery = tools.discovery()
    assert discovery.say("START")["message"] == "OK"
    assert discovery.say("LIST") == {"eventType": "list", "ports": []}
    first = place.serve(config(devices={"m1": {}, "m2": TCP}))
    assert [port["label"] for port in discovery.say("LIST")["ports"]] == ["t/m1", "t/m2"]
    assert discovery.say("STOP")["message"] == "OK"
    assert discovery.say("START_SYNC")["message"] == "OK"
    assert {discovery.hear()["port"]["label"] for _ in range(2)} == {"t/m1", "t/m2"}
    second = place.serve(config(bench="u"), bench="u")
    assert discovery.hear()["port"]["label"] == "u/m1"
    first.process.send_signal(signal.SIGSTOP)  # it is there, and does not answer
    second.stop()
    gone = discovery.hear()
    assert (gone["eventType"], gone["port"]["address"]) == ("remove", str(place.runtime / "u" / "m1"))
    first.kill()  # and leaves its socket behind
    assert {discovery.hear()["eventType"] for _ in range(2)} == {"remove"}
    discovery.hang_up()
    assert discovery.ended() == 0


@pytest.mark.thorough
def test_the_ide_1_8_has_the_terminals_of_benches_that_come_and_go(place: Place, tools: Tools) -> None:
    discovery = tools.discovery_of_ide_1_8()
    assert discovery.say("START_SYNC") == {"eventType": "start_sync", "message": "OK"}
    first = place.serve(config(devices={"m1": {}, "m2": TCP, "s1": {"profile": "sac"}}))
    added = [discovery.hear() for _ in range(2)]  # its serial monitor opens no socket
    assert [(each["eventType"], each["port"]["label"]) for each in added] == [
        ("add", "t/m1"),
        ("add", "t/s1"),
    ]
    ports = [each["port"] for each in added]
    boards = [port["identificationPrefs"]["."] for port in ports]
    assert boards == ["hil:virtual:mechaduino", "hil:virtual:sac"]
    addresses = [port["address"] for port in ports]
    assert ports[0]["protocolLabel"] == "Virtual board (hil)"
    second = place.serve(config(bench="u"), bench="u")
    assert discovery.hear()["port"]["label"] == "u/m1"
    first.stop()
    removed = {"eventType": "remove", "port": {"address": addresses[0], "protocol": "hil"}}
    assert discovery.hear() == removed
    assert discovery.hear()["port"]["address"] == addresses[1]
    place.serve(config(devices={"m1": {}}))
    again = discovery.hear()
    assert (again["eventType"], again["port"]["address"]) == ("add", addresses[0])
    second.stop()
    assert discovery.hear()["eventType"] == "remove"
    assert discovery.say("STOP")["eventType"] == "stop"
    discovery.terminate()
    assert discovery.ended() == 0


def test_a_monitor_loses_its_port_or_its_client(place: Place, tools: Tools) -> None:
    server = place.serve(config()).ready()
    address = server.ask("list")["devices"][0]["address"]
    monitor = tools.monitor()
    with Ide() as ide:
        assert monitor.say(f"OPEN {ide.address} {address}")["message"] == "OK"
        ide.accept().close()
        assert monitor.hear() == {
            "eventType": "port_closed",
            "message": "lost the TCP connection with the client",
        }
        until(lambda: server.status()["clients"] == 0, "the port to be closed")
        assert monitor.say("CLOSE") == {
            "eventType": "close",
            "error": True,
            "message": "port already closed",
        }
        assert monitor.say(f"OPEN {ide.address} {address}")["message"] == "OK"
        with ide.accept() as board:
            assert board.ask(b"p").startswith(b"stepNumber: 0 , Angle: ")
            server.stop()
            gone = monitor.hear()
            assert gone["eventType"] == "port_closed"
            assert "bench has stopped" in gone["message"]
        refused = monitor.say(f"OPEN {ide.address} {address}")
        assert (refused["eventType"], refused["error"]) == ("open", True)
        assert address in refused["message"]
        assert monitor.say(f"OPEN {ide.address} /dev/null")["error"] is True
    monitor.hang_up()
    assert monitor.ended() == 0


def test_a_monitor_whose_client_does_not_listen(place: Place, tools: Tools) -> None:
    server = place.serve(config())
    address = server.ask("list")["devices"][0]["address"]
    with Ide() as ide:
        nobody = ide.address
    monitor = tools.monitor()
    refused = monitor.say(f"OPEN {nobody} {address}")
    assert refused["error"] is True
    assert f"nobody listens at {nobody}" in refused["message"]
    assert monitor.say(f"OPEN 127.0.0.1:99999 {address}")["error"] is True
    until(lambda: server.status()["clients"] == 0, "the port to be closed")
    assert monitor.say("QUIT")["eventType"] == "quit"


def test_a_slow_ide_gets_every_byte(place: Place, tools: Tools) -> None:
    server = place.serve(config()).ready()
    address = server.ask("list")["devices"][0]["address"]
    with server.client() as direct:
        direct.write(b"q")
        expected = direct.quiet(0.5)
    monitor = tools.monitor()
    with Ide() as ide:
        assert monitor.say(f"OPEN {ide.address} {address}")["message"] == "OK"
        with ide.accept() as board:
            board.write(b"q" * 20)
            until(lambda: server.status()["backlog_bytes"] > 0, "a backlog")
            assert monitor.say("DESCRIBE")["message"] == "OK"
            assert board.read_exactly(20 * len(expected), piece=4096) == 20 * expected
    assert server.status()["dropped_bytes"] == 0


def resets(place: Place) -> int:
    lines = (place.folder / "log").read_text().splitlines()
    return sum(isinstance(decode(read_line(line)).input, Reset) for line in lines if '"input":' in line)


def touch(server: Server, baud: int, *, others: int = 0) -> None:
    """Open the port at this rate and close it, as an upload begins."""
    address, connects = server.ask("list")["devices"][0]["address"], server.status()["connects"]
    with serial.Serial(address, baud):
        until(lambda: server.status()["clients"] == 1 + others, "the client")
    until(
        lambda: server.status()["connects"] == connects + 1 and server.status()["clients"] == others,
        "the client's end",
    )


def test_closing_at_1200_baud_resets_the_board(place: Place) -> None:
    server = place.serve(config(speed=2), "--log", str(place.folder / "log")).ready()
    with server.client() as client:
        client.write(b"y")
        until(lambda: server.status()["snapshot"]["loop_on"], "the closed loop")
    touch(server, 1200)
    with server.client() as client:
        assert b"----- Mechaduino" in client.read_until(MENU_END)
        client.ask(b"p", b"stepNumber: 0 , Angle: ")
    assert not server.status()["snapshot"]["loop_on"]
    server.stop()
    assert resets(place) == 1
    assert "identical" in place.cli("replay", str(place.folder / "log"))


def test_what_is_no_touch(place: Place) -> None:
    """Another rate, somebody who still has the port open, a board on a UART."""
    server = place.serve(config(devices={"m1": {}, "m2": {"baud": 1200}}), "--log", str(place.folder / "log"))
    server.ready()
    for baud in (9600, 115200):
        touch(server, baud)
    with serial.Serial(server.ask("list")["devices"][0]["address"], 9600) as first:
        until(lambda: server.status()["clients"] == 1, "the first client")
        touch(server, 1200, others=1)
        first.baudrate = 9601  # the line is shared: what the last one leaves counts
    until(lambda: server.status()["clients"] == 0, "the first client's end")
    address = server.ask("list")["devices"][1]["address"]
    with serial.Serial(address, 1200):
        until(lambda: server.status("m2")["clients"] == 1, "the client on the UART")
    until(lambda: server.status("m2")["clients"] == 0, "its end")
    server.stop()
    assert resets(place) == 0
