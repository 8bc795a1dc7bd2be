"""A SAC's network port: a node that is not ours, two SACs on a wire, the log of a run with packets."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from e2e_support import HIL, PATIENCE_S, Client, Place, config, until

from device_profiles.sac.packet import encode

FOREIGN = Path(__file__).with_name("foreign_node.py")
SAC: dict[str, Any] = {"profile": "sac", "flash": {}}
ONE = config(speed=5, devices={"s1": SAC | {"network": "pty"}})
TWO = config(speed=5, devices={"s1": SAC, "s2": SAC}, segments={"bus0": {"stations": ["s1", "s2"]}})


def foreign(place: Place, *arguments: str) -> subprocess.Popen[str]:
    path = str(place.runtime / "t" / "s1.network")
    return subprocess.Popen(
        [sys.executable, "-I", str(FOREIGN), path, *arguments], stdout=subprocess.PIPE, text=True
    )


@pytest.mark.thorough
def test_a_foreign_master_is_answered(place: Place) -> None:
    server = place.serve(ONE)
    with server.client("s1") as terminal:
        terminal.read_until(b"SAC>")
        for data, answer in (
            ("m200v150ad", "1 85 ACK True\n"),
            ("!m200", "1 85 NAK True\n"),
            (" hello", "1 85 ACK True\n"),
        ):
            assert foreign(place, "master", "85", data).communicate(timeout=PATIENCE_S)[0] == answer
        assert terminal.read_until(b"SAC>") == b"\r\nhello\r\nSAC>"
        until(lambda: server.status("s1")["snapshot"]["pulses"] == 400, "200 steps")
        assert foreign(place, "master", "86", "y").communicate(timeout=PATIENCE_S)[0] == ""


def test_packets_that_are_longer_than_a_port_takes_at_a_time(place: Place) -> None:
    """The firmware runs for the end of a packet, and for nothing before it."""
    server = place.serve(config(devices={"s1": SAC | {"network": "pty"}}, speed=1))
    with server.client("s1") as terminal:
        terminal.read_until(b"SAC>")
        for length in (9, 10, 11, 30, 60):
            said = " " + "x" * (length - 1)
            answer = foreign(place, "master", "85", said).communicate(timeout=PATIENCE_S)[0]
            assert answer == "1 85 ACK True\n"
            assert terminal.read_until(b"SAC>") == f"\r\n{said[1:]}\r\nSAC>".encode()


def test_a_foreign_master_reads_a_board_without_crc(place: Place) -> None:
    server = place.serve(ONE)
    with server.client("s1") as terminal:
        terminal.read_until(b"SAC>")
        terminal.ask(b"$H0\r", b"SAC>")
        assert foreign(place, "master", "85", "y").communicate(timeout=PATIENCE_S)[0] == "1 85 ACK True\n"


def test_a_foreign_node_is_talked_to(place: Place) -> None:
    server = place.serve(ONE)
    with server.client("s1") as terminal:
        terminal.read_until(b"SAC>")
        node = foreign(place, "node", "90", "20")
        assert node.stdout
        assert node.stdout.readline() == "ready\n"
        terminal.ask(b"90m3000\r", b"SAC>")
        assert node.stdout.readline() == "90 85 b'm3000' True\n"
        terminal.ask(b"90 ahoy\r", b"SAC>")
        assert node.stdout.readline() == "90 85 b' ahoy' True\n"
        assert terminal.read_until(b"SAC>") == b"\r\nyou said ahoy\r\nSAC>"
        terminal.ask(b"\\.again\r", b"SAC>")  # a reply goes to who spoke last
        assert "90 85 b'.again' True\n" in (node.stdout.readline(), node.stdout.readline())
        node.kill()
        node.communicate()


def test_two_sacs_on_a_wire_talk_and_the_run_can_be_replayed(place: Place) -> None:
    log = place.folder / "log.jsonl"
    server = place.serve(TWO, "--log", str(log))
    with server.client("s1") as one, server.client("s2") as two:
        for client in (one, two):
            client.read_until(b"SAC>")
        two.ask(b"$CM86\r", b"SAC>")
        two.ask(b"$R\r", b"SAC>")
        one.ask(b"86m100v150ads\r", b"SAC>")
        one.ask(b"m100v150ads\r", b"SAC>")
        one.ask(b"86 ready?\r", b"SAC>")
        assert two.read_until(b"SAC>") == b"\r\nready?\r\nSAC>"
        one.ask(b"0y\r", b"SAC>")
        until(lambda: server.status("s2")["snapshot"]["pulses"] == 200, "the other one's steps")
        assert server.status("s1")["snapshot"]["pulses"] == 0
    server.stop()
    replayed = subprocess.run([HIL, "replay", str(log)], capture_output=True, text=True, timeout=PATIENCE_S)
    assert replayed.stdout.startswith("identical: "), replayed


def test_a_network_port_is_listed_and_can_be_sent_to(place: Place) -> None:
    server = place.serve(ONE)
    with server.client("s1") as terminal, Client(server.ask("list")["devices"][0]["network"]) as network:
        terminal.read_until(b"SAC>")
        server.ask("send", device="s1.network", data=encode(85, 1, b" hi").hex())
        assert terminal.read_until(b"SAC>") == b"\r\nhi\r\nSAC>"
        assert network.read_exactly(7) == b"\2\1\x55\6\3\xdd\0"
    assert "s1.network" in place.cli("list")
    assert f"s1.network at {place.runtime}/t/s1.network" in server.output
