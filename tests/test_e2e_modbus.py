"""Modbus of a running bench, asked by pymodbus: its synchronous client and its asynchronous one."""

import asyncio
import json
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest
from e2e_support import PATIENCE_S, SAC_READY_NS, Place, Server, config, reload, until
from pymodbus.client import AsyncModbusTcpClient, ModbusSerialClient, ModbusTcpClient

TYPES = ModbusTcpClient.DATATYPE
DOOR = {"modbus": {"listen": "127.0.0.1:0"}}
M1, S1 = 1, 2
DEVICES = {"m1": {}, "s1": {"profile": "sac", "flash": {}}}


def number_of(server: Server) -> int:
    return int(server.ask("status")["bridges"]["modbus"]["listen"][0].rpartition(":")[2])


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    with Place() as place:
        yield place


@pytest.fixture(scope="module")
def server(place: Place) -> Server:
    return place.serve(config(devices=DEVICES, bridges=DOOR)).ready()


@pytest.fixture
def client(server: Server) -> Iterator[ModbusTcpClient]:
    with ModbusTcpClient("127.0.0.1", port=number_of(server), timeout=PATIENCE_S) as client:
        yield client


class Map:
    """Registers of a device by their names, as ``hil modbus map`` prints them."""

    def __init__(self, server: Server, device: str) -> None:
        self.rows = {
            (row["table"], row["name"]): row for row in server.ask("registers", device=device)["rows"]
        }

    def at(self, table: str, name: str) -> int:
        return int(self.rows[table, name]["address"])


def i32(client: ModbusTcpClient, address: int, unit: int) -> int:
    answer = client.read_input_registers(address, count=2, device_id=unit)
    return int(client.convert_from_registers(answer.registers, TYPES.INT32))


def bits(client: ModbusTcpClient, address: int, unit: int) -> bool:
    return bool(client.read_discrete_inputs(address, count=1, device_id=unit).bits[0])


def test_position_in_registers_start_bit_done_bit(server: Server, client: ModbusTcpClient) -> None:
    of = Map(server, "m1")
    assert not client.write_coil(of.at("coils", "enable"), True, device_id=M1).isError()
    target = client.convert_to_registers(90.5, TYPES.FLOAT32)
    where, start = of.at("holding_registers", "move_abs.position_deg"), of.at("coils", "move_abs")
    assert not client.write_registers(where, target, device_id=M1).isError()
    assert not client.write_coil(start, True, device_id=M1).isError()
    until(lambda: bits(client, of.at("discrete_inputs", "move_abs.done"), M1), "the done bit")
    assert i32(client, 6, M1) == pytest.approx(90_500, abs=500)  # its loop never stands still
    assert i32(client, 14, M1) == pytest.approx(90_500, abs=1)
    assert abs(i32(client, 12, M1)) < 500
    assert not client.read_coils(start, count=1, device_id=M1).bits[0]
    assert client.read_input_registers(3, count=1, device_id=M1).registers == [ord("x")]
    client.write_coil(of.at("coils", "disable"), True, device_id=M1)


def test_a_command_in_one_write(server: Server, client: ModbusTcpClient) -> None:
    of = Map(server, "s1")
    number = of.at("coils", "move_rel")
    words = [number + 1, *client.convert_to_registers(-45.0, TYPES.FLOAT32)]
    before = i32(client, 6, S1)
    assert not client.write_registers(of.at("holding_registers", "command"), words, device_id=S1).isError()
    until(lambda: bits(client, number, S1), "the done bit")
    assert i32(client, 6, S1) - before == pytest.approx(-45_000, abs=1000)


def test_a_motion_that_something_else_ended_is_refused(server: Server, client: ModbusTcpClient) -> None:
    of = Map(server, "m1")
    client.write_coil(of.at("coils", "enable"), True, device_id=M1)
    number = of.at("coils", "move_rel")
    angle = client.convert_to_registers(36_000.0, TYPES.FLOAT32)
    client.write_registers(of.at("holding_registers", "move_rel.angle_deg"), angle, device_id=M1)
    client.write_coil(number, True, device_id=M1)
    assert client.read_coils(number, count=1, device_id=M1).bits[0]
    assert not client.write_register(0, 4, device_id=M1).isError()  # the control word's stop
    until(lambda: bits(client, 300 + number, M1), "the refused bit")
    assert not bits(client, number, M1)
    client.write_register(0, 2, device_id=M1)  # disable, and the bit of stop is 0 again


@pytest.mark.parametrize("end", ["stop", "reset"])
def test_a_move_of_a_stepper_that_something_else_ended_is_not_done(
    server: Server, client: ModbusTcpClient, end: str
) -> None:
    of = Map(server, "s1")
    number = of.at("coils", "move_rel")
    until(lambda: not bits(client, 202, S1), "standstill")
    words = [number + 1, *client.convert_to_registers(36_000.0, TYPES.FLOAT32)]
    assert not client.write_registers(of.at("holding_registers", "command"), words, device_id=S1).isError()
    assert not client.write_coil(of.at("coils", end), True, device_id=S1).isError()
    until(lambda: bits(client, 300 + number, S1), "the refused bit", 8)
    assert not bits(client, number, S1)
    server.ready("s1", since_ns=server.status("s1")["snapshot"]["at_ns"], boot_ns=SAC_READY_NS)


def test_what_is_refused_is_an_exception_and_said_in_the_log(server: Server, client: ModbusTcpClient) -> None:
    of = Map(server, "m1")
    client.write_coil(of.at("coils", "disable"), True, device_id=M1)
    setting = client.convert_to_registers(1.0, TYPES.FLOAT32)
    at = of.at("holding_registers", "position.position_deg")
    assert not client.write_registers(at, setting, device_id=M1).isError()
    answer = client.write_coil(of.at("coils", "position"), True, device_id=M1)
    assert (answer.isError(), answer.exception_code) == (True, 6)
    until(lambda: "unit 1: exception 06: not_now: " in server.output, "the log")
    assert client.read_input_registers(0, count=1, device_id=77).exception_code == 10
    exceptions = server.ask("status")["bridges"]["modbus"]["exceptions"]
    assert exceptions["06"] >= 1
    assert exceptions["10"] >= 1


def test_gains_are_holding_registers(server: Server, client: ModbusTcpClient) -> None:
    at = Map(server, "m1").at("holding_registers", "pKp")
    old = client.read_holding_registers(at, count=2, device_id=M1).registers
    words = client.convert_to_registers(12.5, TYPES.FLOAT32)
    done = client.readwrite_registers(
        read_address=at, read_count=2, write_address=at, values=words, device_id=M1
    )
    assert done.registers == words
    assert server.ask("state", device="m1")["pKp"] == 12.5
    client.write_register(at, old[0], device_id=M1)  # half of it changes nothing
    assert server.ask("state", device="m1")["pKp"] == 12.5
    client.write_register(at + 1, old[1], device_id=M1)
    assert client.read_input_registers(at, count=2, device_id=M1).registers == old
    too_large = client.convert_to_registers(1e7, TYPES.FLOAT32)
    assert client.write_registers(at, too_large, device_id=M1).exception_code == 3


def test_pins_and_masks(server: Server, client: ModbusTcpClient) -> None:
    of = Map(server, "s1")
    level = of.at("discrete_inputs", "pin_sync")
    for wanted in (False, True, False):
        client.write_coils(of.at("coils", "input.sync"), [wanted], device_id=S1)
        assert bits(client, level, S1) is wanted
    answer = client.mask_write_register(address=0, and_mask=0xFFFF, or_mask=0xFFFF, device_id=S1)
    assert not answer.isError()


def test_identification(server: Server, client: ModbusTcpClient) -> None:
    said = client.read_device_information(read_code=2, device_id=S1).information
    assert (said[0], said[1], said[6]) == (b"hil", b"sac", b"t/s1")
    assert said[2].decode() == server.ask("list")["version"]


@pytest.mark.parametrize("block", [16, 1000])
def test_the_time_in_a_block_goes_on(server: Server, client: ModbusTcpClient, block: int) -> None:
    def at_ns() -> float:
        words = client.read_input_registers(block, count=4, device_id=M1).registers
        return float(client.convert_from_registers(words, TYPES.UINT64))

    assert Map(server, "m1").at("input_registers", "at_ns") == 1000
    times = [at_ns() for _ in range(10)]
    assert times == sorted(times)
    until(lambda: at_ns() > times[-1], "the time to go on")


def test_many_clients_at_once(server: Server) -> None:
    async def one(number: int) -> int:
        client = AsyncModbusTcpClient("127.0.0.1", port=number, timeout=PATIENCE_S)
        assert await client.connect()
        try:
            done = 0
            for _ in range(50):
                answer = await client.read_input_registers(1000, count=10, device_id=M1)
                done += not answer.isError()
            return done
        finally:
            client.close()

    async def all_of_them() -> list[int]:
        number = number_of(server)
        return await asyncio.gather(*(one(number) for _ in range(32)))

    assert asyncio.run(all_of_them()) == [50] * 32


def test_low_words_first(place: Place, server: Server) -> None:
    with Place() as other:
        text = config(bridges={"modbus": {**DOOR["modbus"], "word_order": "low_first", "units": {"m1": 7}}})
        door = other.serve(text).ready()
        with ModbusTcpClient("127.0.0.1", port=number_of(door), timeout=PATIENCE_S) as client:
            words = client.read_input_registers(4, count=2, device_id=7).registers
            crc = client.convert_from_registers(words, TYPES.UINT32, word_order="little")
            assert crc == door.ask("registers", device="m1")["crc"]
            said = client.convert_to_registers(0.25, TYPES.FLOAT32, word_order="little")
            at = Map(door, "m1").at("holding_registers", "pKi")
            assert not client.write_registers(at, said, device_id=7).isError()
            assert door.ask("state", device="m1")["pKi"] == 0.25
            assert client.read_input_registers(0, count=1, device_id=1).exception_code == 10
        assert door.ask("status")["bridges"]["modbus"]["units"] == {"7": "m1"}


def test_a_reload_takes_a_unit_away_and_brings_it_back() -> None:
    bridges = {"modbus": {**DOOR["modbus"], "units": {"m1": 1, "s1": 2}}}
    with Place() as place:
        server = place.serve(config(devices=DEVICES, bridges=bridges)).ready()
        with ModbusTcpClient("127.0.0.1", port=number_of(server), timeout=PATIENCE_S) as client:
            assert not client.read_input_registers(0, count=2, device_id=S1).isError()
            assert reload(place, server, {"m1": {}}, bridges=bridges)["removed"] == ["s1"]
            assert client.read_input_registers(0, count=2, device_id=S1).exception_code == 11
            assert not client.read_input_registers(0, count=2, device_id=M1).isError()
            reload(place, server, DEVICES, bridges=bridges)
            assert not client.read_input_registers(0, count=2, device_id=S1).isError()


def test_a_serial_line() -> None:
    """A pty, opened several times. pymodbus sets up its port twice, which a pty refuses with a parity."""
    line = {"path": "plc", "baud": 1200, "units": {"m1": 17}}
    with Place() as place:
        server = place.serve(config(bridges={"modbus": {**DOOR["modbus"], "rtu": [line]}})).ready()
        address = server.ask("status")["bridges"]["modbus"]["listen"][1]
        assert address == str(place.runtime / "t" / "plc")
        enable = Map(server, "m1").at("coils", "enable")
        for _ in range(3):
            with ModbusSerialClient(address, baudrate=1200, timeout=PATIENCE_S) as client:
                assert client.read_input_registers(0, count=1, device_id=17).registers == [1]
                assert not client.report_device_id(device_id=17).isError()
                assert not client.diag_query_data(b"\xa5\x37", device_id=17).isError()
                assert client.read_input_registers(3000, count=1, device_id=17).exception_code == 2
                client.write_coil(enable, True, device_id=0, no_response_expected=True)
                until(lambda: server.status("m1")["snapshot"]["loop_on"], "the broadcast")


def test_a_map_says_which_unit_it_is_on_each_line() -> None:
    lines = [{"path": "a"}, {"path": "b", "units": {"m1": 17}}]
    with Place() as place:
        server = place.serve(config(bridges={"modbus": {**DOOR["modbus"], "rtu": lines}}))
        printed = place.hil("modbus", "map", "m1", "--runtime-dir", str(place.runtime))
        tcp, a, b = server.ask("status")["bridges"]["modbus"]["listen"]
        assert printed.startswith(f"m1 is unit 1 at {tcp}, {a}\nm1 is unit 17 at {b}\nm1, a mech")


def test_the_map_of_a_running_bench(place: Place, server: Server) -> None:
    folder = "--runtime-dir", str(place.runtime)
    table = place.hil("modbus", "map", "m1", *folder)
    assert table.startswith(
        f"m1 is unit 1 at 127.0.0.1:{number_of(server)}\nm1, a mechaduino: map version 1, CRC"
    )
    of = json.loads(place.hil("modbus", "map", "s1", "--format", "json", *folder))
    assert of == server.ask("registers", device="s1")
    assert place.hil("modbus", "map", "s1", "--format", "csv", *folder).count("\n") == len(of["rows"]) + 1
    assert "formats are table" in place.hil("modbus", "map", "s1", "--format", "xml", *folder, code=2)
    assert "no device 'm9'" in place.hil("modbus", "map", "m9", *folder, code=2)
    assert "which bench" in place.hil("modbus", "map", "m1", "-b", "other", *folder, code=1)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "listen": ({"listen": "no where"}, "is no address and no name of a computer"),
    "open": ({"listen": "0.0.0.0:1502"}, "is reached from other computers"),
    "number": ({"units": {"m1": 248}}, "247"),
    "twice": ({"units": {"m1": 1, "s1": 1}}, "unit 1 is m1 and s1"),
    "none": ({"units": {}}, "there is nothing in it"),
    "none on a line": ({"rtu": [{"path": "plc", "units": {}}]}, "there is nothing in it"),
    "lines": (
        {"rtu": [{"path": "plc"}, {"path": "./plc"}]},
        "the bridge modbus has a port in",
    ),
    "order": ({"word_order": "middle"}, "word_order"),
    "tls": ({"tls": {"certificate": "a.pem"}}, "key"),
    "line": ({"rtu": [{"baud": 9600}]}, "either a path or a device"),
    "adapter": ({"rtu": [{"device": "COM1"}]}, "no serial port"),
    "role": ({"tls": {"certificate": "a", "key": "b", "clients": "c", "roles": {"ann": "boss"}}}, "viewer"),
}


@pytest.mark.parametrize("options", WRONG)
def test_options_that_are_wrong_are_refused_with_their_place(place: Place, options: str) -> None:
    given, why = WRONG[options]
    path = place.write(config(devices=DEVICES, bridges={"modbus": given}), "wrong.yaml")
    said = place.cli("check", str(path), code=2)
    assert why in said
    assert f"\n{path}:1:" in said


def test_an_axis_that_is_not_there(place: Place) -> None:
    bridges = {"modbus": {**DOOR["modbus"], "units": {"m9": 1}}}
    said = place.launch(config("u", bridges=bridges), bench="u").refused()
    assert "bridges.modbus.units.m9: there is no axis 'm9' (there are m1)" in said


def test_a_port_that_is_taken(place: Place, server: Server) -> None:
    bridges = {"modbus": {"listen": f"127.0.0.1:{number_of(server)}"}}
    said = place.launch(config("v", bridges=bridges), bench="v").refused()
    assert "is in use by hil (process " in said
    assert "); choose another port, or end it" in said


def test_insecure_is_said() -> None:
    with Place() as place:
        server = place.serve(config(bridges={"modbus": {"listen": "0.0.0.0:0", "insecure": True}}))
        said = "every program that can reach it can move all axes"
        until(lambda: server.output.count(said) == 2, "the log's line and that of the start")
        assert "INSECURE: every program that can reach it can move all axes" in place.cli("status")
        assert server.ask("status")["bridges"]["modbus"]["insecure"]


def test_other_clients_have_their_time_beside_a_flood(server: Server, client: ModbusTcpClient) -> None:
    """A client that asks without end and reads nothing holds up nobody for long."""
    flood, ends = socket.create_connection(("127.0.0.1", number_of(server))), threading.Event()

    def ask() -> None:
        flood.settimeout(0.05)
        while not ends.is_set():
            try:
                flood.send(bytes.fromhex("0001 0000 0006 01 04 03e8 0078") * 300)
            except TimeoutError:
                continue
            except OSError:
                return

    thread = threading.Thread(target=ask)
    thread.start()
    try:
        begun = time.monotonic()
        for _ in range(50):
            assert not client.read_input_registers(1000, count=10, device_id=M1).isError()
        assert time.monotonic() - begun < PATIENCE_S
    finally:
        ends.set()
        thread.join()
        flood.close()
