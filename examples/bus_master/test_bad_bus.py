"""Further tests of ``master.py``: faults on the wire and at nodes, on one bench for all of them."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from hil.testing import ServedBench, live

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def bus() -> Iterator[ServedBench]:
    with live(HERE / "bench.yaml") as made:
        for address in range(4, 36):
            made.type(f"s{address}", b"$CM%d\r" % address, b"$R\r", until=b"SAC>")
        yield made


def master(bus: ServedBench, command: str, first: int = 4, last: int = 35) -> str:
    port = bus.port("bus0.master")
    program = [sys.executable, HERE / "master.py", port, command, str(first), str(last)]
    return subprocess.run(program, capture_output=True, text=True, timeout=120).stdout


def test_all_nodes_are_reached(bus: ServedBench) -> None:
    assert master(bus, "v120") == "32 nodes have it, 0 have not\n"


def test_a_node_that_sends_no_crc_is_understood(bus: ServedBench) -> None:
    for line in (b"$H0\r", b"$H1\r"):
        bus.type("s8", line, until=b"SAC>")
        assert master(bus, "v120", 8, 8) == "1 nodes have it, 0 have not\n"


def test_a_node_that_does_not_acknowledge_is_reported(bus: ServedBench) -> None:
    bus.hil("fault", "inject", "packet_no_ack", "s7.network")
    bus.hil("fault", "inject", "packet_nak", "s9.network")
    assert master(bus, "v120") == (
        "node 7: silence, silence, silence\nnode 9: NAK, NAK, NAK\n30 nodes have it, 2 have not\n"
    )
    bus.hil("fault", "clear")
    assert master(bus, "v120", 7, 9) == "3 nodes have it, 0 have not\n"


def test_a_bad_wire_costs_retries_and_no_node(bus: ServedBench) -> None:
    bus.hil("fault", "inject", "packet_bad_crc", "bus0.master", "rate=0.2", "seed=1")
    report = master(bus, "v120")
    bus.hil("fault", "clear")
    assert "NAK, ACK" in report
    assert report.endswith("32 nodes have it, 0 have not\n")


def test_two_nodes_with_one_address_are_no_silence(bus: ServedBench) -> None:
    bus.hil("fault", "inject", "node_clash", "bus0", "address=12")
    master(bus, "v120", 12, 12)
    bus.hil("fault", "clear")
    assert "collisions" in bus.hil("status")
    assert master(bus, "v120", 12, 12) == "1 nodes have it, 0 have not\n"
