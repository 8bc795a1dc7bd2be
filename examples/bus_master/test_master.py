"""Tests of ``master.py``, in a process of its own, against 32 nodes with faults."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial

HERE = Path(__file__).parent
HIL = Path(sys.executable).with_name("hil")


class Bus:
    """A running bench, and the commands a test needs."""

    def __init__(self, folder: Path) -> None:
        self.where = ["--runtime-dir", str(folder)]
        command = [HIL, "serve", HERE / "bench.yaml", *self.where, "--state-dir", folder / "state"]
        self.daemon = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.daemon.stdout
        for line in self.daemon.stdout:
            if line.startswith("Ctrl-C"):
                break
        self.tap = str(folder / "bus" / "bus0.master")
        for address in range(4, 36):
            with serial.Serial(str(folder / "bus" / f"s{address}"), 38400, timeout=5) as terminal:
                if address == 4:
                    terminal.read_until(b"SAC>")  # all are past their cold start then
                for line in (f"$CM{address}", "$R"):
                    terminal.write(f"{line}\r".encode())
                    terminal.read_until(b"SAC>")

    def hil(self, *arguments: str) -> str:
        command = [HIL, *arguments, *self.where]
        return subprocess.run(command, check=True, capture_output=True, text=True, timeout=60).stdout

    def master(self, command: str, first: int = 4, last: int = 35) -> str:
        program = [sys.executable, HERE / "master.py", self.tap, command, str(first), str(last)]
        return subprocess.run(program, capture_output=True, text=True, timeout=120).stdout


@pytest.fixture(scope="module")
def bus(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bus]:
    made = Bus(tmp_path_factory.mktemp("run"))
    yield made
    made.daemon.terminate()
    made.daemon.communicate(timeout=30)


def test_all_nodes_are_reached(bus: Bus) -> None:
    assert bus.master("v120") == "32 nodes have it, 0 have not\n"


def test_a_node_that_sends_no_crc_is_understood(bus: Bus) -> None:
    with serial.Serial(bus.tap.replace("bus0.master", "s8"), 38400, timeout=5) as terminal:
        for line in ("$H0", "$H1"):
            terminal.write(f"{line}\r".encode())
            terminal.read_until(b"SAC>")
            assert bus.master("v120", 8, 8) == "1 nodes have it, 0 have not\n"


def test_a_node_without_a_voice_is_told(bus: Bus) -> None:
    bus.hil("fault", "inject", "packet_no_ack", "s7.network")
    bus.hil("fault", "inject", "packet_nak", "s9.network")
    assert bus.master("v120") == (
        "node 7: silence, silence, silence\nnode 9: NAK, NAK, NAK\n30 nodes have it, 2 have not\n"
    )
    bus.hil("fault", "clear")
    assert bus.master("v120", 7, 9) == "3 nodes have it, 0 have not\n"


def test_a_bad_wire_costs_retries_and_no_node(bus: Bus) -> None:
    bus.hil("fault", "inject", "packet_bad_crc", "bus0.master", "rate=0.2", "seed=1")
    report = bus.master("v120")
    bus.hil("fault", "clear")
    assert "NAK, ACK" in report
    assert report.endswith("32 nodes have it, 0 have not\n")


def test_two_nodes_with_one_address_are_no_silence(bus: Bus) -> None:
    bus.hil("fault", "inject", "node_clash", "bus0", "address=12")
    bus.master("v120", 12, 12)
    bus.hil("fault", "clear")
    assert "collisions" in bus.hil("status")
    assert bus.master("v120", 12, 12) == "1 nodes have it, 0 have not\n"
