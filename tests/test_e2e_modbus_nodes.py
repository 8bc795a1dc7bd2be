"""Modbus nodes of a running bench on a paced line, asked by real masters at the tap's pty; captured,
dissected and replayed."""

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from e2e_support import HIL, PATIENCE_S, Place, Server, config, until
from pymodbus.client import ModbusSerialClient

BAUD = 19200
WIRE = {
    "bus0": {
        "modbus": {"units": {"m1": 1, "s1": 2}},
        "baud": BAUD,
        "format": "8E1",
        "taps": {"master": {}, "logger": {"listen": True}},
    }
}
DEVICES = {"m1": {}, "s1": {"profile": "sac", "flash": {}}}
VERSION = [1]
needs_mbpoll = pytest.mark.skipif(not shutil.which("mbpoll"), reason="needs mbpoll")
needs_tshark = pytest.mark.skipif(not shutil.which("tshark"), reason="needs tshark")


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    with Place() as place:
        yield place


@pytest.fixture(scope="module")
def server(place: Place) -> Server:
    bench = config(speed=1, devices=DEVICES, segments=WIRE)
    return place.serve(bench, "--log", str(place.folder / "inputs.log")).ready()


@pytest.fixture
def master(place: Place) -> Iterator[ModbusSerialClient]:
    address = str(place.runtime / "t" / "bus0.master")
    # As all masters on a computer that is busy: what does not come is asked for again.
    with ModbusSerialClient(address, baudrate=BAUD, timeout=5, retries=3) as client:
        yield client


@pytest.mark.thorough
def test_pymodbus_moves_an_axis(server: Server, master: ModbusSerialClient) -> None:
    assert master.read_input_registers(0, count=1, device_id=2).registers == VERSION
    # pymodbus takes the last byte for the run state: masters differ in where a text may be.
    assert master.report_device_id(device_id=1).identifier.startswith(b"\1\xffmechaduin")
    assert master.read_input_registers(3000, count=1, device_id=1).exception_code == 2
    assert not master.write_register(0, 1, device_id=1).isError(), "enable"
    high, low = master.convert_to_registers(45.0, master.DATATYPE.FLOAT32)
    assert not master.write_registers(11, [9, high, low], device_id=1).isError()
    until(lambda: master.read_discrete_inputs(8, count=1, device_id=1).bits[0], "the motion's end")
    words = master.read_input_registers(6, count=2, device_id=1).registers
    stands_at = master.convert_from_registers(words, master.DATATYPE.INT32)
    assert isinstance(stands_at, int)
    assert abs(stands_at - 45_000) < 1000


@needs_mbpoll
def test_mbpoll_reads_registers(place: Place, server: Server) -> None:
    address = str(place.runtime / "t" / "bus0.master")
    command = ["mbpoll", "-m", "rtu", "-b", str(BAUD), "-P", "none", "-0", "-1", "-o", "5"]

    def polled() -> str:
        done = subprocess.run(
            [*command, "-a", "2", "-t", "3", "-r", "0", "-c", "1", address],
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
        )
        return done.stdout if "[0]:" in done.stdout else ""

    assert re.search(r"^\[0\]:\s+1$", until(polled, "an answer for mbpoll"), re.MULTILINE)


def test_status_and_faults_know_nodes(place: Place, server: Server, master: ModbusSerialClient) -> None:
    master.read_input_registers(0, count=1, device_id=1)
    (row,) = server.ask("segments")
    assert {"m1.modbus", "s1.modbus", "bus0.master"} <= row["stations"].keys()
    assert (row["nodes"]["m1.modbus"]["unit"], row["nodes"]["s1.modbus"]["unit"]) == (1, 2)
    assert row["nodes"]["m1.modbus"]["answers"] >= 1
    shown = place.hil("status")
    assert re.search(r"m1\.modbus +1 ", shown), shown
    number = server.ask("inject", fault="modbus_exception", target="m1.modbus", parameters={"code": 6})
    assert master.read_input_registers(0, count=1, device_id=1).exception_code == 6
    server.ask("clear", **number)
    assert master.read_input_registers(0, count=1, device_id=1).registers == VERSION
    assert "answers come late" in place.cli("fault", "kinds", "modbus_late")


@pytest.mark.thorough
@needs_tshark
def test_a_capture_in_words_and_in_tshark(place: Place, server: Server, master: ModbusSerialClient) -> None:
    paths = {source: place.folder / f"{source}.pcapng" for source in ("bus0", "m1.modbus")}
    where = ["--runtime-dir", str(place.runtime)]
    capturing = [
        subprocess.Popen([HIL, "capture", source, "-w", str(path), *where]) for source, path in paths.items()
    ]
    try:
        until(lambda: all(path.exists() and path.stat().st_size for path in paths.values()), "the captures")
        assert master.read_input_registers(0, count=1, device_id=1).registers == VERSION
        assert master.read_holding_registers(4000, count=1, device_id=1).exception_code == 2
        decoded = {
            source: until(lambda path=path: _decoded(path, 4), f"four frames of {source}")  # type: ignore[misc]
            for source, path in paths.items()
        }
    finally:
        for process in capturing:
            process.terminate()
            process.wait(PATIENCE_S)
    for source, lines in decoded.items():
        assert [line.split(f"{source} ", 1)[1] for line in lines[-4:]] == [
            "to 1: read input register 0",
            "from 1: input register 0: 1",
            "to 1: read holding register 4000",
            "from 1: function 3: exception 02 (illegal data address)",
        ]
        assert _dissected(paths[source]) == [
            "Query: Unit:   1, Func:   4: Read Input Registers",
            "Response: Unit:   1, Func:   4: Read Input Registers",
            "Query: Unit:   1, Func:   3: Read Holding Registers",
            "Response: Unit:   1, Func:   3: Read Holding Registers. Exception returned",
        ]


def _decoded(path: Path, count: int) -> list[str]:
    """Lines of a decoded capture, if there are so many."""
    out = subprocess.run([HIL, "decode", str(path)], capture_output=True, text=True).stdout
    lines = out.splitlines()
    return lines if len(lines) >= count else []


def _dissected(path: Path) -> list[str]:
    """What stock tshark says of the frames of a capture, whose CRCs are right."""
    options = ["-d", "rtacser.data,mbrtu", "-o", "mbrtu.crc_verification:TRUE"]
    fields = ["-T", "fields", "-e", "mbrtu.crc16.status", "-e", "_ws.col.Info"]
    command = ["tshark", "-r", str(path), *options, *fields]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=2 * PATIENCE_S).stdout
    rows = [line.split("\t") for line in shown.splitlines()]
    assert {status for status, _ in rows} == {"1"}, shown
    return [info.strip() for _, info in rows][-4:]


def test_the_log_is_the_same_again(place: Place, server: Any) -> None:
    """Last of this file: the daemon ends."""
    server.stop()
    replayed = place.hil("replay", str(place.folder / "inputs.log"), timeout_s=2 * PATIENCE_S)
    assert "identical" in replayed, replayed
