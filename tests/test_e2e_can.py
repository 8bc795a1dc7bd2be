"""A CAN bus of a running bench: python-can's slcan client at a pty and a TCP port, faults, status, metrics,
reload, replay."""

import re
import subprocess
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import can
import pytest
from e2e_support import HIL, PATIENCE_S, Client, Place, Server, config, refused, until
from prometheus_client.parser import text_string_to_metric_families

DEVICES = {"m1": {}, "m2": {}}
BUS: dict[str, Any] = {
    "bit_rate": 500_000,
    "nodes": {"m1": 5, "m2": 6},
    "taps": {"a": {}, "b": {"port": "tcp"}},
}
BRIDGES = {"metrics": {"listen": "127.0.0.1:0"}}


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    with Place() as place:
        yield place


@pytest.fixture(scope="module")
def server(place: Place) -> Server:
    bench = config(speed=1, devices=DEVICES, can={"can0": BUS}, bridges=BRIDGES)
    return place.serve(bench, "--log", str(place.folder / "inputs.log"))


def address(server: Server, tap: str) -> str:
    return next(row["port"] for row in server.ask("list")["taps"] if row["tap"] == tap)


@contextmanager
def opened(server: Server, tap: str) -> Iterator[can.BusABC]:
    """python-can's client at a tap, when the adapter is on the bus: the client does not wait for that."""
    channel = address(server, tap)
    with can.Bus(interface="slcan", channel=channel, bitrate=500_000, sleep_after_open=0) as bus:
        until(lambda: server.ask("buses")[0]["nodes"][tap]["state"] != "off", "the adapter")
        yield bus
    until(lambda: server.ask("buses")[0]["nodes"][tap]["state"] == "off", "its end")


@pytest.fixture
def pty(server: Server) -> Iterator[can.BusABC]:
    with opened(server, "can0.a") as bus:
        yield bus


@pytest.fixture
def tcp(server: Server) -> Iterator[can.BusABC]:
    with opened(server, "can0.b") as bus:
        yield bus


def received(bus: can.BusABC, can_id: int) -> can.Message:
    """Next message with an identifier."""

    def found() -> can.Message | None:
        while bus.serialPortOrig.in_waiting:  # type: ignore[attr-defined]
            message = bus.recv(0)  # None for an answer to a frame that was sent
            if message and message.arbitration_id == can_id:
                return message
        return None

    return until(found, f"a message {can_id:03X}")  # type: ignore[return-value]


def test_two_programs_and_the_nodes_hear_each_other(pty: can.BusABC, tcp: can.BusABC) -> None:
    pty.send(can.Message(arbitration_id=0x123, data=b"\1\2\3", is_extended_id=False))
    tcp.send(can.Message(arbitration_id=0x1ABCDEF0, data=bytes(8), is_extended_id=True))
    assert received(tcp, 0x123).data == b"\1\2\3"
    assert received(pty, 0x1ABCDEF0).is_extended_id
    pty.send(can.Message(arbitration_id=0, data=b"\x81\0", is_extended_id=False))  # NMT: reset all
    assert {received(tcp, 0x705).data[0], received(pty, 0x706).data[0]} == {0}


def test_a_thousand_frames_each_way_come_in_order(pty: can.BusABC, tcp: can.BusABC) -> None:
    heard: dict[str, list[int]] = {"pty": [], "tcp": []}
    for number in range(1000):
        data = number.to_bytes(2, "big")
        pty.send(can.Message(arbitration_id=0x201, data=data, is_extended_id=False))
        tcp.send(can.Message(arbitration_id=0x202, data=data, is_extended_id=False))
        if number % 50 == 0:
            take(pty, tcp, heard)
    until(lambda: take(pty, tcp, heard) and all(len(each) >= 1000 for each in heard.values()), "all frames")
    assert heard == {"pty": list(range(1000)), "tcp": list(range(1000))}


def take(pty: can.BusABC, tcp: can.BusABC, heard: dict[str, list[int]]) -> bool:
    for name, bus, can_id in (("pty", pty, 0x202), ("tcp", tcp, 0x201)):
        while bus.serialPortOrig.in_waiting:  # type: ignore[attr-defined]
            message = bus.recv(0)  # None for an answer to a frame that was sent
            if message and message.arbitration_id == can_id:
                heard[name].append(int.from_bytes(message.data, "big"))
    return True


def test_a_capture_has_the_bytes_at_a_tap(
    place: Place, server: Server, pty: can.BusABC, tcp: can.BusABC
) -> None:
    path = place.folder / "tap.pcapng"
    where = ("--runtime-dir", str(place.runtime))
    with subprocess.Popen([HIL, "capture", "can0.a", "-w", str(path), *where]) as capturing:
        until(lambda: path.exists() and path.stat().st_size, "the capture")
        pty.send(can.Message(arbitration_id=0x321, data=b"\7", is_extended_id=False))
        tcp.send(can.Message(arbitration_id=0x322, data=b"\x08", is_extended_id=False))
        until(lambda: all(each in path.read_bytes() for each in (b"t321107\r", b"t322108\r")), "both lines")
        capturing.terminate()


def test_list_and_status_know_the_bus(place: Place, server: Server, pty: can.BusABC) -> None:
    assert re.search(r"m2\.canopen +node 6 on can0", place.hil("list"))
    shown = place.hil("status")
    assert re.search(r"can0 +500000 +\d+\.\d% +\d+ ", shown), shown
    assert re.search(r"m1\.canopen +5 +error-active ", shown), shown
    (row,) = server.ask("buses")
    assert row["nodes"]["can0.a"]["state"] == "error-active"
    assert row["nodes"]["can0.b"]["state"] == "off"
    assert '"load_percent"' in place.hil("status", "--json")


def test_metrics_have_what_the_bus_counts(server: Server) -> None:
    root = server.ask("status")["bridges"]["metrics"]["root"]
    with urllib.request.urlopen(root, timeout=PATIENCE_S) as answer:
        families = list(text_string_to_metric_families(answer.read().decode()))
    now = {(s.name, *s.labels.values()): s.value for f in families for s in f.samples}
    (row,) = server.ask("buses")
    assert 0 < now["hil_can_frames_total", "can0"] <= row["frames"]
    assert 0 < now["hil_can_load_ratio", "can0"] < 1
    assert now["hil_can_node_bus_off", "m1.canopen"] == 0
    assert now["hil_can_node_sent_total", "m1.canopen"] >= 1


def test_a_node_that_is_bus_off_comes_back(place: Place, server: Server, pty: can.BusABC) -> None:
    where = ("--runtime-dir", str(place.runtime))
    number = server.ask("inject", fault="driver_stuck", target="m1.canopen", parameters={})
    until(lambda: server.ask("buses")[0]["nodes"]["m1.canopen"]["state"] != "error-active", "errors")
    server.ask("clear", **number)
    assert place.hil("fault", "inject", "bus_off", "m1.canopen", *where).startswith("fault ")
    until(lambda: server.ask("buses")[0]["nodes"]["m1.canopen"]["state"] == "error-active", "its recovery")
    assert "a node is bus-off, once" in place.cli("fault", "kinds", "bus_off")
    assert place.hil("fault", "inject", "wire_swapped", "can0.a", *where, code=2).startswith("hil: ")


def test_a_client_with_another_rate_is_a_failure_of_the_bench(server: Server) -> None:
    with Client(address(server, "can0.b")) as client:
        assert client.ask(b"S3\rO\r", b"\r\r") == b"\r\r"
        (problem,) = [each for each in server.ask("health")["problems"] if each["kind"] == "bus"]
        assert problem["about"] == "can0.b"
        assert server.ask("health")["state"] == "failed"
        client.ask(b"C\r", b"\r")
        assert not [each for each in server.ask("health")["problems"] if each["kind"] == "bus"]


def test_completion_knows_buses_and_nodes(place: Place, server: Server) -> None:
    said = place.hil("_names", "targets", "fault", "inject", "bus_off", "--runtime-dir", str(place.runtime))
    assert {"m1.canopen\tCANopen node of can0", "can0\tCAN bus", "can0.a\ttap"} <= set(said.splitlines())


def test_a_reload_keeps_a_bus_as_it_is(place: Place, server: Server) -> None:
    why = refused(place, server, DEVICES, speed=1, can={"can0": BUS | {"bit_rate": 250_000}}, bridges=BRIDGES)
    assert why == "can.can0.bit_rate: 500000 -> 250000: only a restart of the daemon does this"


def test_the_log_is_the_same_again(place: Place, server: Server) -> None:
    """Last of this file: the daemon ends."""
    server.stop()
    replayed = place.hil("replay", str(place.folder / "inputs.log"), timeout_s=60)
    assert "identical" in replayed, replayed


def test_a_bench_without_can_imports_nothing_of_it(place: Place) -> None:
    source = (
        "import sys; from hil.cli.entry import main\n"
        "import atexit; atexit.register(lambda: print('MODULES', *sorted(sys.modules)))\nmain()\n"
    )
    bench = place.write(config(), "plain.yaml")
    plain = place.script(source, "serve", str(bench), *place.folders()).started()
    said = plain.stop()
    modules = set(said.split("MODULES", 1)[1].split())
    assert "hil.sim.bench" in modules
    of_can = [
        name
        for name in modules
        if re.match(r"hil\.(sim|wire)\.can\b|hil\.canopen|virtual_ports\.can|can\b", name)
    ]
    assert of_can == []
