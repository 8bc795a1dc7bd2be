"""Segments as their users have them: masters at taps, real lines, what status says."""

import os
import subprocess
import sys
import tty
from pathlib import Path
from typing import Any

import pytest
import serial
from e2e_support import HIL, PATIENCE_S, SAC_READY_NS, Client, Place, config, until

from device_profiles.sac.packet import encode

pytestmark = pytest.mark.filterwarnings("ignore:set(Daemon|Name)")  # pyserial 3.5 of its threads
FOREIGN = Path(__file__).with_name("foreign_node.py")
SAC: dict[str, Any] = {"profile": "sac", "flash": {}}
ACK = b"\x06"


def bench(taps: dict[str, Any], count: int = 2, speed: float = 5, **segment: Any) -> str:
    devices = {f"s{n}": SAC for n in range(1, count + 1)}
    segments = {"bus0": {"stations": list(devices), "taps": taps} | segment}
    return config(speed=speed, devices=devices, segments=segments)


def start(place: Place, text: str, *options: str) -> Any:
    server = place.serve(text, *options)
    server.ready(boot_ns=SAC_READY_NS)
    for n, row in enumerate(server.ask("list")["devices"]):
        if n:  # the first one keeps 85
            with server.client(row["device"]) as terminal:
                terminal.ask(b"$CM%d\r" % (85 + n), b"SAC>")
                terminal.ask(b"$R\r", b"SAC>")
    return server


def address(server: Any, tap: str) -> str:
    taps = server.ask("segments")[0]["taps"]
    return next(row["address"] for row in taps if row["tap"] == tap)


def test_a_master_at_a_pty_and_one_at_rfc2217(place: Place) -> None:
    log = place.folder / "log.jsonl"
    taps = {"master": {"port": "pty"}, "far": {"port": "rfc2217"}, "spy": {"port": "tcp", "listen": True}}
    server = start(place, bench(taps), "--log", str(log))
    path = address(server, "bus0.master")
    assert path == f"{place.runtime}/t/bus0.master"
    with Client(address(server, "bus0.spy")) as spy:
        for node, data, answer in (("85", "m200v150ad", "ACK"), ("86", "!m1", "NAK"), ("86", "y", "ACK")):
            run = [sys.executable, "-I", str(FOREIGN), path, "master", node, data]
            said = subprocess.run(run, capture_output=True, text=True, timeout=PATIENCE_S).stdout
            assert said == f"1 {node} {answer} True\n"
        with serial.serial_for_url(address(server, "bus0.far"), 38400, timeout=PATIENCE_S) as far:
            far.write(encode(86, 4, b"m100ad"))
            assert far.read(7) == encode(4, 86, ACK)
        heard = spy.read_until(encode(4, 86, ACK))
        assert encode(85, 1, b"m200v150ad") in heard
        spy.write(encode(85, 1, b"m999"))
    until(lambda: server.status("s2")["snapshot"]["pulses"] == 200, "the second one's steps")
    (row,) = server.ask("segments")
    assert (row["packets"], row["errors"], row["collisions"]) == (8, {"CRC": 1}, 0)
    assert set(row["stations"]) == {"s1.network", "s2.network", "bus0.master", "bus0.far", "bus0.spy"}
    assert "bus0" in place.cli("status")
    server.stop()
    replayed = subprocess.run([HIL, "replay", str(log)], capture_output=True, text=True, timeout=PATIENCE_S)
    assert replayed.stdout.startswith("identical: "), replayed


def test_two_nodes_with_one_address_collide_and_status_says_so(place: Place) -> None:
    server = place.serve(bench({"master": {}}))
    server.ready(boot_ns=SAC_READY_NS)
    with Client(address(server, "bus0.master")) as master:
        master.write(encode(85, 1, b"v99"))
        until(lambda: server.ask("segments")[0]["packets"] == 2, "the answer")  # equal bits at equal times
        (row,) = server.ask("segments")
        assert row["collisions"] == 1
        assert row["notes"] == ["two stations have one address 85: s1.network, s2.network"]
        assert "two stations have one address 85" in place.cli("status")


def test_a_right_bench_is_healthy_from_its_first_moment(place: Place) -> None:
    text = bench({"master": {}}, count=3, speed=1)
    start(place, text).stop()
    server = place.serve(text)

    def is_over() -> bool:
        assert server.ask("health")["problems"] == []
        return all(server.status(name)["snapshot"]["at_ns"] > SAC_READY_NS for name in ("s1", "s2", "s3"))

    until(is_over, "the end of the cold start")


def test_a_real_node_keeps_its_address(place: Place) -> None:
    """The real line is a pseudo-terminal, behind which the test is the node 86."""
    link = place.folder / "ttyRS485"
    master, slave = os.openpty()
    tty.setraw(slave)
    link.symlink_to(os.ttyname(slave))
    os.close(slave)
    taps = {"line": {"port": {"kind": "serial", "url": str(link), "baud": 38400}}}
    server = start(place, bench(taps))
    with Client.__new__(Client) as node, server.client("s1") as terminal:
        node._socket, node.fd, node.got = None, master, bytearray()
        terminal.ask(b"86 are you real?\r", b"SAC>")
        packet = encode(86, 85, b" are you real?")
        assert node.read_until(b"\0").startswith(packet[:-2])
        node.read_until(encode(85, 86, ACK))  # the twin's: nothing was known of a real one
        node.write(encode(85, 86, b" yes"))
        assert terminal.read_until(b"SAC>") == b"\r\nyes\r\nSAC>"
        node.read_until(encode(86, 85, ACK))
        terminal.ask(b"86 and now?\r", b"SAC>")
        node.read_until(encode(86, 85, b" and now?"))
        node.write(encode(85, 86, ACK))
        (row,) = server.ask("segments")
        note = "address 86 is a real node: s2.network was taken off the wire, until it has another address"
        assert row["notes"] == [note]
        assert terminal.ask(b"vd\r", b"SAC>") == b"vd\r\n0\t0\r\nSAC>"
        assert node.quiet(0.2) == b""


def test_a_client_has_its_speed_both_ways(place: Place) -> None:
    """Boards at another speed than the usual one: the taps follow them, or a client sets it."""
    fast = {**SAC, "bauds": {"network": 115200}}
    server = place.serve(config(speed=1, devices={"s1": fast}, segments={"bus0": {
        "stations": ["s1"], "baud": 38400, "taps": {"master": {}},
    }}))  # fmt: skip
    server.ready("s1", boot_ns=SAC_READY_NS)
    (row,) = server.ask("segments")
    assert row["notes"] == [
        "the speeds differ, and stations of two speeds read wrong bytes: s1.network 115200 baud;"
        " bus0.master 38400 baud"
    ]
    problems = server.ask("status")["health"]["problems"]
    assert [(each["kind"], each["about"]) for each in problems] == [("segment", "bus0")]
    with serial.Serial(address(server, "bus0.master"), 115200, timeout=20) as master:
        master.write(encode(85, 1, b"y"))
        assert master.read(7) == encode(1, 85, ACK)
        (row,) = server.ask("segments")
        assert row["notes"] == []


def test_more_than_a_tap_takes_at_once_goes_out_all_the_same(place: Place) -> None:
    """The rest goes out although nothing else happens on the wire that could wake anybody."""
    text = config(
        speed=5,
        devices={"s1": SAC},
        segments={"bus0": {"taps": {"a": {}, "b": {"port": "tcp", "listen": True}}}},
    )
    server = place.serve(text)
    with Client(address(server, "bus0.a")) as talker, Client(address(server, "bus0.b")) as listener:
        data = bytes(range(256)) * 20
        talker.write(data)
        assert listener.read_exactly(len(data)) == data
        for _ in range(80):
            talker.write(encode(99, 1, b"y"))
        assert listener.read_exactly(80 * 7) == encode(99, 1, b"y") * 80
    listed = place.cli("list")
    assert "bus0.a" in listed
    assert "bus0.b" in listed


def test_faults_of_twins_are_listed_and_a_capture_may_outlive_the_bench(place: Place) -> None:
    server = place.serve(bench({"master": {}}))
    path = place.folder / "c.pcapng"
    where = ["--runtime-dir", str(place.runtime)]
    capture = subprocess.Popen([HIL, "capture", "bus0", "-w", str(path), *where])
    until(lambda: path.exists() and path.stat().st_size > 0, "the capture's beginning")

    def hil(*arguments: str) -> str:
        done = subprocess.run([HIL, *arguments, *where], capture_output=True, text=True, timeout=PATIENCE_S)
        return done.stdout + done.stderr

    assert hil("fault", "inject", "byte_drop", "s1", "rate=.1") == "fault 1\n"
    assert (
        hil("fault", "inject", "byte_drop", "s1", "rate=.1", "rate=.2")
        == "hil: rate is given twice; leave one out\n"
    )
    assert hil("fault", "list").startswith("1 byte_drop s1 rate=0.1 towards=client")
    assert "s1: fault 1: byte_drop" in place.cli("status")
    server.stop()  # says it if there is a traceback
    assert capture.wait(PATIENCE_S) == 1  # the bench ended before it
