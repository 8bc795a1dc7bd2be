"""Real lines with adapters that echo what they send: at the Modbus door, and at taps of segments."""

import struct
from collections.abc import Iterator
from typing import Any

import pytest
from e2e_support import Place, Server, config, free_port, until
from echoing_line import EchoingLine
from pymodbus.client import ModbusSerialClient

from bridges.modbus.protocol.frame import encode

BAUD = 19200
SAC = {"profile": "sac", "flash": {}}
VERSION = 1
"""First input register of a unit."""
SAC_READY_NS = 1_200_000_000
SHAPES = [{}, {"in_one": True}, {"in_one": True, "late_s": 0.016}]


@pytest.fixture
def place() -> Iterator[Place]:
    with Place() as place:
        yield place


@pytest.fixture(params=SHAPES, ids=["by characters", "in one piece", "late"])
def line(place: Place, request: pytest.FixtureRequest) -> Iterator[EchoingLine]:
    made = EchoingLine(place.folder / "tty", BAUD, **request.param)
    yield made
    made.close()


def door(place: Place, devices: dict[str, Any], **of_line: Any) -> Server:
    rtu = [{"device": str(place.folder / "tty"), "baud": BAUD, **of_line}]
    bridges = {"modbus": {"listen": f"127.0.0.1:{free_port()}", "rtu": rtu}}
    return place.serve(config(speed=1, devices=devices, bridges=bridges))


def echo(place: Place, server: Server, name: str = "") -> dict[str, Any]:
    told: dict[str, Any] = server.ask("status")["echoes"][name or str(place.folder / "tty")]
    return told


@pytest.mark.thorough
@pytest.mark.parametrize("of_line", [{}, {"echo": True}])
def test_a_door_answers_each_request_once(place: Place, line: EchoingLine, of_line: dict[str, Any]) -> None:
    server = door(place, {"m1": {}}, **of_line).ready()
    read, answer = encode(1, 4, bytes((0, 0, 0, 1))), encode(1, 4, bytes((2, 0, VERSION)))
    for count in range(1, 4):
        line.say(read)
        until(lambda count=count: len(line.sent) >= count * len(answer), "the answer")
        until(lambda count=count: echo(place, server)["bytes"] == count * len(answer), "its echo")
    assert line.sent == answer * 3
    assert echo(place, server) == {"state": "yes", "bytes": 3 * len(answer), "collisions": 0}
    assert "echo: yes, 21 bytes that came back were dropped" in " ".join(place.cli("status").split())


def test_a_door_carries_an_order_out_once(place: Place, line: EchoingLine) -> None:
    """The first that is sent is an answer with the bytes of its question: nothing is known yet."""
    server = door(place, {"m1": {}}).ready()
    rows = place.cli("modbus", "map", "m1", "--runtime-dir", str(place.runtime)).splitlines()
    coil = next(int(row.split()[1]) for row in rows if row.startswith("coils") and "disable" in row.split())
    order = encode(1, 5, struct.pack(">HH", coil, 0xFF00))
    line.say(order)
    until(lambda: len(line.sent) >= len(order), "the answer")
    until(lambda: echo(place, server)["bytes"] == len(order), "its echo")
    assert line.sent == order
    assert server.ask("status")["bridges"]["modbus"]["commands"] == 1
    assert echo(place, server)["state"] == "unknown yet"


def test_a_line_without_an_echo_is_told(place: Place) -> None:
    line = EchoingLine(place.folder / "tty", BAUD, echoes=False)
    server = door(place, {"m1": {}}, echo=False).ready()
    assert echo(place, server) == {"state": "no", "bytes": 0, "collisions": 0}
    line.close()


def segment(place: Place, baud: int, nodes: dict[str, Any], **of_tap: Any) -> dict[str, Any]:
    port = {"kind": "serial", "url": str(place.folder / "tty"), "baud": baud}
    return {"bus0": {**nodes, "baud": baud, "taps": {"master": {}, "line": {"port": port, **of_tap}}}}


@pytest.mark.thorough
@pytest.mark.parametrize("of_tap", [{}, {"echo": True}])
def test_nodes_at_a_real_line_answer(place: Place, line: EchoingLine, of_tap: dict[str, Any]) -> None:
    wire = segment(place, BAUD, {"modbus": {"units": {"m1": 1}}}, **of_tap)
    server = place.serve(config(speed=1, devices={"m1": {}}, segments=wire)).ready("x")
    address = str(place.runtime / "t" / "bus0.master")
    with ModbusSerialClient(address, baudrate=BAUD, timeout=5, retries=0) as master:
        for _ in range(3):
            assert master.read_input_registers(0, count=1, device_id=1).registers == [VERSION]
            assert not master.write_register(0, 0, device_id=1).isError(), "no verb"
    until(lambda: echo(place, server, "bus0.line")["bytes"] == len(line.sent), "the echoes")
    (row,) = server.ask("segments")
    assert (row["errors"], row["collisions"], row["notes"]) == ({}, 0, [])
    assert row["packets"] == 12
    assert echo(place, server, "bus0.line")["state"] == "yes"


def test_a_twin_is_not_taken_for_a_real_node_by_its_own_echo(place: Place) -> None:
    line = EchoingLine(place.folder / "tty", 38400)
    wire = segment(place, 38400, {"stations": ["s"]})
    server = place.serve(config(speed=1, devices={"s": SAC}, segments=wire)).ready("s", boot_ns=SAC_READY_NS)
    for command in ("v100", "m200", "m200"):
        words = ("line", "send", "bus0.master", "85", command, "--runtime-dir", str(place.runtime))
        assert ": done, " in place.cli(*words)
    until(lambda: echo(place, server, "bus0.line")["bytes"] == len(line.sent), "the echoes")
    (row,) = server.ask("segments")
    assert (row["errors"], row["collisions"], row["notes"]) == ({}, 0, [])
    assert server.status("s")["snapshot"]["pulses"] > 0
    line.close()


def test_an_echo_of_a_pty_is_refused(place: Place) -> None:
    rtu = [{"path": "plc", "echo": True}]
    bench = config(devices={"m1": {}}, bridges={"modbus": {"rtu": rtu}})
    said = place.cli("check", str(place.write(bench)), code=2)
    assert "bridges.modbus.rtu.0.echo: a pty has no adapter that could echo" in " ".join(said.split())
